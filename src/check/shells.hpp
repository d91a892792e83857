// Measures the size, the holes and the nesting of the components of a mesh.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "check/boundary_defects.hpp"
#include "mesh/components.hpp"
#include "mesh/mesh.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::check {

// The kind of a component. A component has an inside if it has no boundary edges and each edge has as many triangles in
// one direction as in the other. Its sheets may touch at edges or vertices.
// Inside an even number of other shells, a component bounds a body; its triangles should face outward. Inside an odd
// number, it bounds a cavity; its triangles should face inward.
enum class Shell {
  open,          // has boundary edges, so it has no inside
  not_oriented,  // closed, but an edge has more triangles in one direction than in the other, so it has no inside
  body,          // faces outward, inside an even number of shells
  cavity,        // faces inward, inside an odd number
  inside_out,    // faces inward, inside an even number
  undecided,     // like inside_out, but inside the bounding box of an open component, whose cavity it may be
  nested         // faces outward, inside an odd number: a body inside a body
};
constexpr auto words_of(Shell /*type*/) {
  return std::array{Word{Shell::open, "open"},
                    Word{Shell::not_oriented, "not oriented"},
                    Word{Shell::body, "body"},
                    Word{Shell::cavity, "cavity"},
                    Word{Shell::inside_out, "inside out"},
                    Word{Shell::undecided, "cavity or inside out"},
                    Word{Shell::nested, "body within a body"}};
}

struct Component {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;  // not counting triangles that repeat an index
  EdgeDefects edges;
  std::uint64_t loops = 0;  // boundary loops
  double area = 0;
  double volume = 0;  // negative if the triangles face inward; 0 without an inside
  mesh::Bounds bounds;
  std::optional<std::int64_t> genus;  // absent if an edge or a vertex is non-manifold or an edge is misoriented
  Shell shell = Shell::open;
  std::uint32_t enclosing_shells = 0;  // number of other shells; 0 without an inside

  [[nodiscard]] bool has_inside() const { return shell != Shell::open && shell != Shell::not_oriented; }
};

// Describes each component, in the order of `components`. mesh/shells.hpp finds the shells around each. The result does
// not depend on the number of threads. The caller reserves memory for the result. Fails with ErrorCode::out_of_memory
// if the working memory exceeds the budget, or with ErrorCode::cancelled.
[[nodiscard]] Result<std::vector<Component>> describe_components(const mesh::Mesh& mesh,
                                                                 const mesh::Components& components,
                                                                 const BoundaryDefects& defects,
                                                                 const Context& context);

}  // namespace isoextract::check
