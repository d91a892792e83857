// Vertex attributes from volumes: from grids of the input, and from other files.
//
// AttributeChoice::from has one of these forms:
//
//   GRID         a grid of the input, if its format names grids: "temperature"; a component of a vector grid,
//                "velocity[x]", or its length, "velocity[length]". "velocity" alone means the whole vector grid, with
//                three components, or else the three scalar grids velocity.x, velocity.y and velocity.z together
//                (also velocity_x or velocityx)
//   FILE         another file with one scalar grid, or with a vector grid alone (three components). Of several volumes,
//                AttributeChoice::volume chooses one
//   FILE[GRID]   a grid of another file
//
// The text counts as a file if it has the extension or the prefix (demo:) of a volume format, or if a file of that
// name exists. A text with a slash also counts as a file if a folder of that name exists. If `from` equals the
// attribute's name, it always means a grid of the input.
//
// A grid of the input's own file is read with the input's read options, except for the component. Another file takes
// from the input: the volume number (if it holds several), the axis order (if it is an array) and the no-data value.
// Settings of the choice replace these.
//
// A file that states no spacing and no origin lies on the input's grid and must have the same dimensions, unless the
// choice sets the spacing (volume_io::ReferenceVolume). A file in another patient space or length unit than the input
// is moved to the input's world (map_between_worlds()), unless the choice sets spacing or origin. FILE cannot be
// standard input or a raw file, which does not describe itself.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "convert/conversion_job.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::convert {

// The file and the grid that a choice names.
struct AttributeLocation {
  std::string file;  // path of another file, or demo:NAME; empty for the input
  std::optional<std::string> grid;
};
[[nodiscard]] AttributeLocation attribute_location(const AttributeChoice& choice);

// One attribute read from volumes: one field for each component. It has all components of samples with two to four
// components, if the choice names no component. An array of four axes holds such samples if its first three axes have
// the input's shape, its last axis has two to four entries, and the choice names no volume.
struct VolumeAttribute {
  AttributeChoice choice;
  std::vector<field::ScalarField> components;  // ScalarField::name is the source's name for messages
  std::optional<AttributeKind> stated_kind;    // stated by the file
  bool in_voxels = false;                      // vectors are in index space: along the voxel axes, in voxels
  Notes notes;                                 // assumptions made, one sentence each
};

struct VolumeAttributes {
  std::vector<VolumeAttribute> found;
  std::vector<MissingAttribute> missing;
};

// Reads the chosen attributes; `input` is the field that was read from the input. Fails as read_volume() does, and with
// ErrorCode::input for a grid of an input whose format names no grids. For optional attributes, and with
// `allow_missing` for all, a missing grid or file goes to `missing` and is no failure.
[[nodiscard]] Result<VolumeAttributes> read_volume_attributes(const SourceOptions& options,
                                                              const field::ScalarField& input, bool allow_missing,
                                                              const Context& context);

// Returns the existing files that attributes name by FILE, with the files that hold their samples separately. The input
// is among them only if an attribute names its path. Reads no samples. Fails as volume_io::list_input_files() does.
[[nodiscard]] Result<std::vector<std::filesystem::path>> attribute_files(const SourceOptions& options,
                                                                         const Context& context);

}  // namespace isoextract::convert
