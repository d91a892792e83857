// Names of all files that a run will write, made and checked before the work starts.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::batch {

// One conversion that needs output names.
struct OutputSource {
  std::int64_t frame = 0;
  std::string input;
  std::string grid;                      // the chosen grid; empty if none was chosen
  std::vector<convert::IsoChoice> isos;  // without duplicates
  bool alone = false;                    // the run's only conversion, so messages need no frame number
  // Further grids of this conversion; each gets a file if the name contains {grid}.
  std::vector<std::string> more_grids = {};
  std::optional<std::int64_t> step = {};  // of a frame of particles

  friend bool operator==(const OutputSource&, const OutputSource&) = default;
};

// A file that a run reads or writes besides the inputs and outputs of its conversions.
struct NamedFile {
  std::string path;
  // Text for messages: in OtherFiles::read the rest of a sentence about the file ("has the options"), in
  // OtherFiles::written a noun ("the table").
  std::string what;
  Hint hint = {};  // for a file that is written, how to choose another name

  friend bool operator==(const NamedFile&, const NamedFile&) = default;
};

struct OtherFiles {
  std::vector<NamedFile> read;
  std::vector<NamedFile> written;
};

using OutputFiles = std::vector<convert::OutputFileJob>;  // of one conversion

// Returns the outputs of every source. `output` is what the user asked for:
//   a template    (output_template.hpp) one file for each source; with {iso} for each iso value, with {grid} for each
//                 grid
//   a folder      an existing one, or a path ending in a slash, which may contain placeholders
//   nothing       the current folder
//   "-"           standard output
//
// Files in a folder are named {stem}.EXTENSION, or {stem}_{frame:04}.EXTENSION if inputs of several frames have the
// same stem. The frame number gets more digits if needed. If two sources read different grids of one frame, _{grid}
// comes before the extension. EXTENSION is `extension` if it is not empty (for outputs that are no meshes), else
// the extension of `format`.
//
// Fails with ErrorCode::usage in these cases:
//   - the template is invalid, or `output` is empty;
//   - the name contains {grid}, but a source has no grid name;
//   - the name contains {step}, but a source has no step;
//   - the name contains {iso}, and the labels are a set (IsoChoice::is_label_set());
//   - the name contains {label} or {name}, and the surfaces are no labels;
//   - the name contains {piece} but none of {iso}, {label} and {name}, for several iso values or labels (a label set of
//     one name is allowed);
//   - several iso values, labels or grids share a file of a format that holds one mesh.
// Fails as check_outputs() does. Folders need not exist.
[[nodiscard]] Result<std::vector<OutputFiles>> name_outputs(std::span<const OutputSource> sources,
                                                            const std::optional<std::string>& output,
                                                            mesh_io::MeshFormat format, std::string_view extension = {},
                                                            const OtherFiles& others = {});

// Returns the same names without check_outputs().
[[nodiscard]] Result<std::vector<OutputFiles>> name_outputs_unchecked(std::span<const OutputSource> sources,
                                                                      const std::optional<std::string>& output,
                                                                      mesh_io::MeshFormat format,
                                                                      std::string_view extension);

// Checks that no two outputs are one file (except devices such as /dev/null), that no output is also read, and that no
// output has the name of a manifest. `outputs[i]` are the files of `sources[i]`. Checks the files of `others`, too.
// Files are compared by files::LocationKeys: one file under two names counts as one. For formats with two files (.gltf
// and .bin), both are checked.
//
// Refuses names with {piece} if two bodies could get the same name, or if a body could get the name of an input or of a
// file in `others.written`. Does not cover data files that an input's header names: convert::check_mesh_files() does.
//
// Fails with ErrorCode::usage; the message names the file and the frames or options that would write it. Takes O(n log
// n) time.
[[nodiscard]] Result<void> check_outputs(std::span<const OutputSource> sources, std::span<const OutputFiles> outputs,
                                         mesh_io::MeshFormat format, const OtherFiles& others = {});

// Returns the input's name without folder and extension: "a" for dir/a.nii.gz, "sphere" for demo:sphere?size=9, "stdin"
// for standard input. For a pattern of slices, returns the text before the number: "slice" for slice_{:03}.png.
[[nodiscard]] std::string stem_of(const std::string& input);

}  // namespace isoextract::batch
