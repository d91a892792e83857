// Attributes of vertices from volumes: grids of the input, and other files.
//
// What AttributeChoice::from says of a volume is
//
//   GRID         a grid of the input, for formats that name their grids: "temperature", or "velocity[x]" and
//                "velocity[length]" of one of vectors. A grid of vectors as a whole, "velocity", has three components,
//                and so have scalar grids velocity.x, velocity.y and velocity.z together
//   FILE         another file with one volume or one scalar grid
//   FILE[GRID]   a grid of another file
//
// It is taken for a file where it has an extension of a format of volumes or is a name like demo:gyroid, where there is
// a file of that name, and where there is a folder of that name and it has a slash in it. What is not told apart from
// the attribute's name is a grid of the input whatever files there are.
//
// A grid of the input's own file is read with the options of the input, another file with the number of the volume, if
// it has several and the choice names none, with the order of axes, if it is an array, and with the value for no data.
// A file that states no spacing and no origin lies on the grid of the input, if it has its shape
// (volume_io::VolumeBeside). Raw files, which do not say what is in them, and standard input are no other files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "field/scalar_field.hpp"

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
  std::optional<AttributeKind> stated_kind;  // by the file
  bool in_voxels = false;                    // vectors along the axes of the voxels, in voxels
  std::vector<std::string> notes;            // what was assumed, a sentence each
};

struct VolumeAttributes {
  std::vector<VolumeAttribute> found;
  std::vector<MissingAttribute> missing;
};

// Reads those of a volume, of which `input` is what was read. Fails as read_volume() does, and with ErrorCode::input
// where the input's format names no grids. A grid or file that is not there is no failure of optional attributes, and
// with `missing_is_fine` of none.
[[nodiscard]] Result<VolumeAttributes> read_volume_attributes(const SourceOptions& options,
                                                              const field::ScalarField& input, bool missing_is_fine,
                                                              const Context& context);

// The other files that attributes of volumes are in and that are there, those that hold samples apart among them. Never
// reads samples.
[[nodiscard]] Result<std::vector<std::filesystem::path>> attribute_files(const SourceOptions& options,
                                                                         const Context& context);

}  // namespace isoextract::convert
