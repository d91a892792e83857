// Vertex attributes: their sources, and the sampling of them at the vertices.
//
// Attributes of particles are interpolated by kernels (points/attribute_sampling.hpp), attributes of volumes
// trilinearly (field/point_samples.hpp). Both are sampled at the vertices' positions in the input's world.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "convert/attribute_kinds.hpp"
#include "convert/attribute_volumes.hpp"
#include "convert/conversion_job.hpp"
#include "convert/particle_source.hpp"
#include "field/affine.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

// Attribute data that stays in memory until the surfaces are extracted.
struct AttributeSource {
  std::variant<ParticleAttributes, std::vector<VolumeAttribute>> from;
  std::vector<MissingAttribute> missing;
  field::Affine world_from_output;
  field::Affine output_from_world;  // attributes change by this map, as their kinds say
  std::vector<NamedKind> kinds;     // of all attributes found, in the order of the job's choices
  // one sentence for each attribute that stays as it is because its kind is unknown
  Notes kind_notes;
};

// Sets the maps of a source and finds the kinds of its attributes. Fails as find_kind() does.
[[nodiscard]] Result<void> set_attribute_maps(AttributeSource& source, const field::Affine& world_from_output,
                                              const field::Affine& output_from_world);

// Returns the kinds without the attributes that only give colors.
[[nodiscard]] std::vector<NamedKind> written_kinds(const AttributeSource& source);

// Result of sampling one attribute at the vertices of a surface.
struct AttributeResult {
  std::string name;
  std::string source;  // name of the values' source, for messages: "fire.vdb: temperature"
  std::size_t components = 1;
  AttributeKind kind = AttributeKind::scalar;
  bool changed = false;  // whether the values were changed with the placement of the mesh, as the kind requires
  std::uint64_t vertices = 0;
  std::uint64_t outside = 0;     // vertices outside dense samples; they have the value at the data boundary
  std::uint64_t not_finite = 0;  // vertices whose value is not a finite number
  // vertices out of every particle's reach; they have the values of the nearest particle
  std::uint64_t vertices_beyond_kernels = 0;
};

// Adds the attributes to the vertices of `mesh` as float32, and returns one result for each attribute. Fails as
// points::sample_attributes() and field::sample_points() do; `mesh` then has none of the attributes.
[[nodiscard]] Result<std::vector<AttributeResult>> add_attributes(const AttributeSource& source, mesh::Mesh& mesh,
                                                                  const Context& context);

}  // namespace isoextract::convert
