// Selects and splits the bodies of a surface: drops small ones, keeps the largest, makes a mesh of each.
//
// A shell is a component that is closed, oriented and manifold. All other components count as open and have no volume
// here. Triangles that repeat an index belong to no component. A shell is a cavity if its triangles face the space that
// it encloses, else an outer shell. A body is an outer shell or an open component, with the cavities directly inside
// it. An outer shell or open component in a cavity is a body of its own. So is a cavity that lies directly inside
// another cavity, or in no other component.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

enum class ComponentMeasure { triangles, area, volume };
constexpr auto words_of(ComponentMeasure /*type*/) {
  return std::array{Word{ComponentMeasure::triangles, "triangles"}, Word{ComponentMeasure::area, "area"},
                    Word{ComponentMeasure::volume, "volume"}};
}

// The removal steps. `least` and `fill_cavities` apply together. Filling a cavity removes the bodies in it, even if the
// body around the cavity is removed as well. `largest` comes last.
struct BodySelection {
  // Removes components that measure less than this. Removing a body removes its cavities; removing a cavity fills it.
  // Keeps a component whose exact size may reach the limit: the comparison allows for the rounding of its vertices.
  // With ComponentMeasure::volume, open components stay, as they have no volume.
  std::optional<double> least;
  ComponentMeasure measure = ComponentMeasure::triangles;
  bool fill_cavities = false;  // fills the cavities of bodies; a cavity that is a body of its own stays
  // Keeps this many bodies, those of the largest outer area (cavities not counted); the first of equal ones.
  std::optional<std::uint64_t> largest;
  // Maps the mesh's coordinates to the space in which areas and volumes are measured.
  glm::dmat3 to_metric{1.0};
};

struct BodyCounts {
  std::uint64_t triangles = 0;
  std::uint64_t components = 0;
  std::uint64_t bodies = 0;  // including open components; all other components are cavities
};

struct BodyFigures {
  BodyCounts before;
  BodyCounts after;
  std::uint64_t without_volume = 0;  // open components that stayed because volume was measured
  StageTime time;
};

struct SelectedBodies {
  mesh::Mesh mesh;
  BodyFigures facts;
};

// Positions, one a vertex, that replace the mesh's own when cavities and bodies are found and measured. Use them for a
// mesh whose vertices were moved away from the isosurface. Empty: the mesh's own positions.
using OriginalPositions = Buffer<glm::vec3>;

// Keeps the components that `options` select, with their vertices, attributes and triangles in order. Filling a cavity
// also removes the components in it. If select_bodies() removes any component, it also drops vertices and triangles
// that belong to no component, so closed components stay closed. Returns the mesh unchanged if nothing is removed. The
// result does not depend on the number of threads. Fails with ErrorCode::out_of_memory or ErrorCode::cancelled.
[[nodiscard]] Result<SelectedBodies> select_bodies(mesh::Mesh mesh, const BodySelection& options,
                                                   const Context& context, OriginalPositions sites = {});

// Adds an attribute that stores the body of each vertex, for split_into_bodies(). Later stages may move or remove
// vertices but must not join components; cavities then stay with their bodies. Fails as select_bodies() does.
[[nodiscard]] Result<void> mark_bodies(mesh::Mesh& mesh, const Context& context, OriginalPositions sites = {});

// Returns one mesh for each body, the largest area first, with all attributes but that of mark_bodies(); an empty list
// for a mesh without triangles. Without that attribute, finds from the positions which cavity is in which body. All
// meshes have the name of `mesh`. Fails with ErrorCode::input, before it splits, if there are more than `most` bodies;
// with ErrorCode::out_of_memory if memory for all bodies beside `mesh` is short; or with ErrorCode::cancelled.
[[nodiscard]] Result<std::vector<mesh::Mesh>> split_into_bodies(mesh::Mesh mesh, std::uint64_t most,
                                                                const Context& context);

}  // namespace isoextract::edit
