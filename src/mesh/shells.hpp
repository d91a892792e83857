// Which closed shells of a mesh lie in which: the one answer for check, pieces and simplification.
//
// A ray goes from the vertex of each shell that is farthest along one direction, in that direction. The shell is in
// those others whose triangles the ray passes an odd number of times. Signs are exact, and a ray through an edge or a
// corner counts as beside it, so one of the triangles there is passed and not two or none. A vertex that is on another
// shell says nothing: the ray starts beside it then, on the side of the material.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/components.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::mesh {

// Of a component: not closed, or which way its triangles face.
enum class Facing : std::uint8_t { open, outward, inward };

struct Surroundings {
  // The other closed components that the component lies in, in rising order.
  std::vector<std::uint32_t> around;
  // Of one that faces inward and lies in no closed one: the first open component that its ray meets.
  std::uint32_t open = Components::kNone;

  // Whether an odd number of closed shells is around: it lies in material, if all of them face as they should.
  [[nodiscard]] bool in_material() const { return around.size() % 2 == 1; }
};

struct ShellQuestion {
  std::vector<Facing> facing{};  // of each component
  bool of_outward = true;        // or only of those that face inward
  bool of_open = false;          // whether `open` is asked for
};

// Of each component, in their order; of one that is open or not asked for, nothing. Shells that share walls do not lie
// in each other; shells that intersect may be told either way. The same for any number of threads. Fails where its
// working memory is more than is left, and with ErrorCode::cancelled; throws std::bad_alloc.
[[nodiscard]] Result<std::vector<Surroundings>> find_surroundings(const Mesh& mesh, const Components& components,
                                                                  const ShellQuestion& question,
                                                                  const Context& context);

}  // namespace isoextract::mesh
