// The components of a mesh as bodies: sizes, holes, and which of the closed ones lie within others.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/words.hpp"
#include "check/mesh_borders.hpp"
#include "mesh/components.hpp"
#include "mesh/mesh.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::check {

// A closed shell in an even number of others bounds a body, and one in an odd number of them the hollow of a body:
// triangles of the former should face outward, those of the latter inward.
enum class Shell {
  open,        // not closed, or not a manifold, or not oriented: it has no inside
  body,        // faces outward, within an even number of shells
  hollow,      // faces inward, within an odd number
  inside_out,  // faces inward, within an even number
  nested       // faces outward, within an odd number: a body within a body
};
constexpr auto words_of(Shell /*type*/) {
  return std::array{Word{Shell::open, "open"}, Word{Shell::body, "body"}, Word{Shell::hollow, "hollow"},
                    Word{Shell::inside_out, "inside out"}, Word{Shell::nested, "body within a body"}};
}

struct Component {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;  // without those that repeat an index
  EdgeDefects edges;
  std::uint64_t loops = 0;  // of open edges
  double area = 0;
  double volume = 0;  // enclosed, negative where it faces inward; 0 unless it is closed
  mesh::Bounds bounds;
  std::optional<std::int64_t> genus;  // nothing where an edge or a vertex is not manifold or not oriented
  Shell shell = Shell::open;
  std::uint32_t within = 0;  // how many other closed shells it lies in; 0 of an open one
};

// In the order of `components`; mesh/shells.hpp says how it is decided what lies within what. The same for any number
// of threads. Fails where its working memory is more than is left, and with ErrorCode::cancelled.
[[nodiscard]] Result<std::vector<Component>> describe_components(const mesh::Mesh& mesh,
                                                                 const mesh::Components& components,
                                                                 const MeshBorders& borders, const Context& context);

}  // namespace isoextract::check
