// Vertex attributes: the sources of their values, and the sampling of these values at the vertices.
//
// Attributes of particles are interpolated by kernels (points/attribute_sampling.hpp), attributes of volumes
// trilinearly (field/point_samples.hpp). Both are sampled at the vertices' positions in the input's world.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "base/reserved_buffer.hpp"
#include "convert/attribute_kinds.hpp"
#include "convert/attribute_volumes.hpp"
#include "convert/conversion_job.hpp"
#include "convert/particle_source.hpp"
#include "field/affine.hpp"
#include "field/point_samples.hpp"
#include "mesh/mesh.hpp"
#include "points/attribute_sampling.hpp"

namespace isoextract::convert {

// Attribute data that stays in memory until the surfaces are extracted.
struct AttributeSource {
  std::variant<ParticleAttributes, std::vector<VolumeAttribute>> from;
  std::vector<MissingAttribute> missing;
  field::Affine world_from_output;
  field::Affine output_from_world;  // map of the mesh, also applied to vector, normal and point attributes
  std::vector<NamedKind> kinds;     // of all attributes found, in the order of the job's choices; unknown ones: scalar
  // one sentence for each written three-component attribute of unknown kind, if the mesh is turned or scaled
  Notes kind_notes;
};

// Sets the maps of a source, and appends the kinds of its attributes and notes about them: call it once. Fails as
// find_kind() does.
[[nodiscard]] Result<void> set_attribute_maps(AttributeSource& source, const field::Affine& world_from_output,
                                              const field::Affine& output_from_world);

// Returns the kinds of the attributes, without attributes that only give colors.
[[nodiscard]] std::vector<NamedKind> written_kinds(const AttributeSource& source);

// Returns the positions of the vertices in the input's world. Fails as Context::reserve() does.
[[nodiscard]] Result<std::shared_ptr<ReservedBuffer<glm::dvec3>>> world_positions(
    const field::Affine& world_from_output, const mesh::Mesh& mesh, const Context& context);

// Result of sampling one attribute at the vertices of a surface.
struct AttributeResult {
  std::string name;
  std::string source;  // name of the values' source, for messages: "fire.vdb: temperature"
  std::size_t components = 1;
  AttributeKind kind = AttributeKind::scalar;
  // whether the map from the input's world to the mesh changes the values: a vector, normal or point of three
  // components
  bool changed = false;
  std::uint64_t vertices = 0;
  std::vector<field::PointCounts> counts;  // of each component; for particles one for all
  // For particles: vertices out of every particle's reach, which have the values of the nearest particle.
  std::uint64_t vertices_beyond_kernels = 0;

  // Returns how many vertices lie outside the dense samples of a volume and have the value at the data boundary; of
  // several components the largest count.
  [[nodiscard]] std::uint64_t outside() const;
  // Returns how many vertices have a value that is not a finite number; of several components the largest count.
  [[nodiscard]] std::uint64_t not_finite() const;
  // Adds the counts of other vertices of the same surface.
  void add(const AttributeResult& other);
};

// The samplers of a source, for many meshes with few vertices each. The source must outlive them.
class AttributeSamplers {
 public:
  // Holds reservations for the tables of the samplers. Fails as the make() functions of the samplers do.
  [[nodiscard]] static Result<AttributeSamplers> make(const AttributeSource& source, const Context& context);

  [[nodiscard]] const points::AttributeSampler* of_particles() const { return particles_ ? &*particles_ : nullptr; }
  // Returns the sampler of a component of an attribute of volumes.
  [[nodiscard]] const field::PointSampler& of_volume(std::size_t attribute, std::size_t component) const {
    return volumes_[attribute][component];
  }

 private:
  std::optional<points::AttributeSampler> particles_;
  std::vector<std::vector<field::PointSampler>> volumes_;
};

// Adds the attributes to the vertices of `mesh` as float32, in the input's world: color_surface() transforms them
// later. Returns one result for each attribute, but none if they come from particles and the mesh has no vertices.
//
// Fails as points::sample_attributes(), field::sample_points(), volume_io::check_mapping_intact() and
// Context::reserve() do; `mesh` then has none of the attributes.
[[nodiscard]] Result<std::vector<AttributeResult>> add_attributes(const AttributeSource& source, mesh::Mesh& mesh,
                                                                  const Context& context);
// Does the same by the samplers of the source. Several threads may call it at once, for different meshes.
[[nodiscard]] Result<std::vector<AttributeResult>> add_attributes(const AttributeSource& source,
                                                                  const AttributeSamplers& samplers, mesh::Mesh& mesh,
                                                                  const Context& context);

}  // namespace isoextract::convert
