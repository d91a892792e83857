// Attributes of vertices: where they come from, and how vertices get them.
//
// Of particles they are interpolated by kernels (points/attribute_sampling.hpp), of volumes linearly along each axis
// (field/point_samples.hpp), at the places of the vertices in the world of the input.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/attribute_kinds.hpp"
#include "convert/attribute_volumes.hpp"
#include "convert/conversion_job.hpp"
#include "convert/particle_source.hpp"
#include "field/affine.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

// What is kept of a source until its surfaces are there.
struct AttributeSource {
  std::variant<ParticleAttributes, std::vector<VolumeAttribute>> from;
  std::vector<MissingAttribute> missing;
  field::Affine world_from_output;
  field::Affine output_from_world;      // that attributes are changed by, as their kinds say
  std::vector<NamedKind> kinds;         // of all that were found, in the order of their choices
  std::vector<std::string> kind_notes;  // a sentence each, of those that stay as they are because nothing says theirs
};

// Sets the placement of a source, and the kinds. Fails as find_kind() does.
[[nodiscard]] Result<void> place_attributes(AttributeSource& source, const field::Affine& world_from_output,
                                            const field::Affine& output_from_world);

// Without those that only give colours.
[[nodiscard]] std::vector<NamedKind> written_kinds(const AttributeSource& source);

// How one attribute came to the vertices of a surface.
struct CarriedAttribute {
  std::string name;
  std::string source;  // what its values are of, for messages: "fire.vdb: temperature"
  std::size_t components = 1;
  AttributeKind kind = AttributeKind::scalar;
  bool changed = false;  // with the placement of the mesh, as that kind is
  std::uint64_t vertices = 0;
  std::uint64_t outside = 0;       // of dense samples: they have the value at the border
  std::uint64_t not_finite = 0;    // with a value that is no finite number
  std::uint64_t out_of_reach = 0;  // of particles: they have the values of the nearest one
};

// Adds the attributes to the vertices of `mesh`, as float32, and tells how it went. Fails as
// points::sample_attributes() and field::sample_points() do; the mesh is then without them.
[[nodiscard]] Result<std::vector<CarriedAttribute>> add_attributes(const AttributeSource& source, mesh::Mesh& mesh,
                                                                   const Context& context);

}  // namespace isoextract::convert
