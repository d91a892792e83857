// Attributes of vertices: where they come from, and how vertices get them.
//
// Of particles they are interpolated by kernels (points/attribute_sampling.hpp), of volumes linearly along each axis
// (field/point_samples.hpp), at the places of the vertices in the world of the input. What AttributeChoice::from says
// of a volume is
//
//   GRID         a grid of the input, for formats that name their grids: "temperature", or "velocity[x]" and
//                "velocity[length]" of one of vectors. A grid of vectors as a whole, "velocity", has three components
//   FILE         another file with one volume or one scalar grid
//   FILE[GRID]   a grid of another file
//
// It is taken for a file where it has an extension of a format of volumes or is a name like demo:gyroid, where there is
// a file of that name, and where there is a folder of that name and it has a slash in it. What is not told apart from
// the attribute's name is a grid of the input whatever files there are. Of the options of the input,
// a grid of the same file is read with all; another file with the number of the volume, if it has several. Raw files,
// which do not say what is in them, and standard input are no other files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "convert/conversion_job.hpp"
#include "convert/particle_source.hpp"
#include "field/affine.hpp"
#include "field/scalar_field.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

// What a choice names of a volume.
struct AttributePlace {
  std::string file;  // another one: its path, or demo:NAME; empty for the input
  std::optional<std::string> grid;
};
[[nodiscard]] AttributePlace attribute_place(const AttributeChoice& choice);

// One attribute of volumes: a field a component.
struct VolumeAttribute {
  AttributeChoice choice;
  std::vector<field::ScalarField> components;
};

// What is kept of a source until its surfaces are there.
struct AttributeSource {
  std::variant<ParticleAttributes, std::vector<VolumeAttribute>> from;
  field::Affine world_from_output;
};

// Reads those of a volume, of which `input` is what was read. Fails as read_volume() does, and with ErrorKind::input
// where the input's format names no grids.
[[nodiscard]] Result<std::vector<VolumeAttribute>> read_volume_attributes(const SourceOptions& options,
                                                                          const field::ScalarField& input,
                                                                          const Context& context);

// The other files that attributes of volumes are in, those that hold samples apart among them. Never reads samples.
[[nodiscard]] Result<std::vector<std::filesystem::path>> attribute_files(const SourceOptions& options,
                                                                         const Context& context = Context());

// How one attribute came to the vertices of a surface.
struct AttributeRecord {
  double iso = 0;
  std::string name;
  std::string source;  // what its values are of, for messages: "fire.vdb: temperature"
  std::size_t components = 1;
  std::uint64_t vertices = 0;
  std::uint64_t outside = 0;       // of dense samples: they have the value at the border
  std::uint64_t not_finite = 0;    // with a value that is no finite number
  std::uint64_t out_of_reach = 0;  // of particles: they have the values of the nearest one
};

// Adds the attributes to the vertices of `mesh`, as float32, and tells how it went; `iso` is left to the caller. Fails
// as points::sample_attributes() and field::sample_points() do; the mesh is then without them.
[[nodiscard]] Result<std::vector<AttributeRecord>> add_attributes(const AttributeSource& source, mesh::Mesh& mesh,
                                                                  const Context& context);

// What there is to tell of it: a sentence without its full stop each.
[[nodiscard]] std::vector<std::string> notes_of(const AttributeRecord& record, const std::string& label);

}  // namespace isoextract::convert
