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
  bool alone = false;                    // the run has no other conversion, so messages need no frame number
  // Further grids of this conversion; each gets a file if the name contains {grid}.
  std::vector<std::string> more_grids = {};

  friend bool operator==(const OutputSource&, const OutputSource&) = default;
};

// A file that a run reads or writes besides the inputs and outputs of its conversions.
struct NamedFile {
  std::string path;
  std::string what;  // for a file that is read, what it does ("has the options"), else what it is ("the table")
  Hint hint = {};    // for a file that is written, how to choose another name

  friend bool operator==(const NamedFile&, const NamedFile&) = default;
};

struct OtherFiles {
  std::vector<NamedFile> read;
  std::vector<NamedFile> written;
};

using OutputFiles = std::vector<convert::OutputFileJob>;  // of one conversion

// Returns the outputs of every source. `output` is what the user asked for:
//   a template    output_template.hpp; with {iso} each iso value gets a file, else a source's surfaces share one
//   a folder      an existing one, or any text that ends with a slash, in which words may occur
//   nothing       the current folder
//   "-"           standard output
//
// Files in a folder are named {stem}.EXTENSION, or {stem}_{frame:04}.EXTENSION if inputs of several frames have the
// same stem. They get more digits if a frame number needs them, and then _{grid} if one frame has several grids.
// EXTENSION is the format's unless another is given, because not all outputs are meshes.
//
// Fails with ErrorCode::usage in these cases: the template is invalid; it contains {grid} but no grid was chosen;
// several iso values share a file of a format that holds one mesh; it contains {piece} but not {iso}, for several iso
// values. Fails as check_outputs() does. Folders need not exist.
[[nodiscard]] Result<std::vector<OutputFiles>> name_outputs(std::span<const OutputSource> sources,
                                                            const std::optional<std::string>& output,
                                                            mesh_io::MeshFormat format, std::string_view extension = {},
                                                            const OtherFiles& others = {});

// Returns the same names without check_outputs().
[[nodiscard]] Result<std::vector<OutputFiles>> name_outputs_unchecked(std::span<const OutputSource> sources,
                                                                      const std::optional<std::string>& output,
                                                                      mesh_io::MeshFormat format,
                                                                      std::string_view extension);

// Checks that every file is written once, that no file is both written and read, and that no file has a manifest's
// name. `outputs` are those of `sources`; `others` are checked together with them. Files are compared by their place on
// disk, so links and different spellings of an existing path make no difference. Formats with two files (.gltf and
// .bin) count both.
//
// Refuses names with {piece} if some piece numbers could make two of them equal, or equal to an input. Does not cover
// data files that an input's header names: convert::check_mesh_files() does.
//
// Fails with ErrorCode::usage; the message names the file and who would write it. Takes O(n log n) time and two file
// system queries for each file.
[[nodiscard]] Result<void> check_outputs(std::span<const OutputSource> sources, std::span<const OutputFiles> outputs,
                                         mesh_io::MeshFormat format, const OtherFiles& others = {});

// Returns the input's name without folder and extension: "a" for dir/a.nii.gz, "sphere" for demo:sphere?size=9, "stdin"
// for standard input.
[[nodiscard]] std::string stem_of(const std::string& input);

}  // namespace isoextract::batch
