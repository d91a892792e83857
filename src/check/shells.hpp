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

// A component without open edges, each of whose edges has as many triangles along it as against it, has an inside, also
// if sheets of it touch at edges or vertices. One inside an even number of other shells bounds a body; its triangles
// should face outward. One inside an odd number bounds a cavity; its triangles should face inward.
enum class Shell {
  open,          // has open edges: no inside
  not_oriented,  // closed, but an edge has more triangles along it than against it: no inside
  body,          // faces outward, inside an even number of shells
  hollow,        // faces inward, inside an odd number
  inside_out,    // faces inward, inside an even number
  undecided,     // as inside_out, but within the bounds of an open component, of which it may be a cavity
  nested         // faces outward, inside an odd number: a body inside a body
};
constexpr auto words_of(Shell /*type*/) {
  return std::array{Word{Shell::open, "open"},
                    Word{Shell::not_oriented, "not oriented"},
                    Word{Shell::body, "body"},
                    Word{Shell::hollow, "hollow"},
                    Word{Shell::inside_out, "inside out"},
                    Word{Shell::undecided, "hollow or inside out"},
                    Word{Shell::nested, "body within a body"}};
}

struct Component {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;  // without triangles that repeat an index
  EdgeDefects edges;
  std::uint64_t loops = 0;  // loops of open edges
  double area = 0;
  double volume = 0;  // enclosed; negative if it faces inward, 0 without an inside
  mesh::Bounds bounds;
  std::optional<std::int64_t> genus;  // absent if an edge or a vertex is non-manifold or an edge is misoriented
  Shell shell = Shell::open;
  std::uint32_t within = 0;  // number of other shells around it; 0 without an inside

  [[nodiscard]] bool has_inside() const { return shell != Shell::open && shell != Shell::not_oriented; }
};

// Describes each component, in the order of `components`. mesh/shells.hpp decides which shell lies inside which. The
// result does not depend on the number of threads. The caller reserves memory for the result. Fails with
// ErrorCode::out_of_memory if the working memory exceeds the budget, or with ErrorCode::cancelled.
[[nodiscard]] Result<std::vector<Component>> describe_components(const mesh::Mesh& mesh,
                                                                 const mesh::Components& components,
                                                                 const BoundaryDefects& defects,
                                                                 const Context& context);

}  // namespace isoextract::check
