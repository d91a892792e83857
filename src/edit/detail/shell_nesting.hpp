// Which shells lie within which: cavities in bodies, bodies in cavities.
//
// From a triangle at the vertex of a shell that is farthest along a direction, a ray goes on in that direction. Next to
// that triangle, outside the shell, is what the shell lies in: air around a body, matter around the wall of a cavity.
// So is the ray up to the first other shell that it meets, which bounds the same air or the same matter. It does not
// start at the vertex, where another shell may touch this one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/component_facts.hpp"
#include "mesh/components.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

struct Nesting {
  static constexpr std::uint32_t kNone = mesh::Components::kNone;

  // Of each component: of the wall of a cavity the body around it, of a body itself. A cavity around which no body is
  // found, as where it lies in matter that goes on beyond the data, is a body by itself.
  std::vector<std::uint32_t> body;
  // Of each body: the cavity that it lies in, or kNone.
  std::vector<std::uint32_t> within;
};

// `facts` are of `components`, which are the mesh's. Takes some 120 bytes a component; throws std::bad_alloc. The same
// for any number of threads.
[[nodiscard]] Nesting find_nesting(const mesh::Mesh& mesh, const mesh::Components& components,
                                   std::span<const mesh::ComponentFacts> facts);

}  // namespace isoextract::edit
