// Where the frames of a run go: the names of all files that will be written, found and checked before work starts.
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

// One conversion that needs names for its outputs.
struct OutputSource {
  std::int64_t frame = 0;
  std::string input;
  std::string grid;                          // the one that was chosen; empty where none was
  std::vector<convert::IsoChoice> isos;      // each once
  bool alone = false;                        // the only one of its run: messages name its input and no frame
  std::vector<std::string> more_grids = {};  // of the same conversion: a file each where the name has a place for them

  friend bool operator==(const OutputSource&, const OutputSource&) = default;
};

// A file that a run reads or writes besides the inputs and outputs of its conversions.
struct NamedFile {
  std::string path;
  std::string what;  // of one that is read what it does ("has the options"), else what it is ("the table")
  Hint hint = {};    // how one that is written gets another name

  friend bool operator==(const NamedFile&, const NamedFile&) = default;
};

struct OtherFiles {
  std::vector<NamedFile> read;
  std::vector<NamedFile> written;
};

using OutputFiles = std::vector<convert::OutputFileJob>;  // of one conversion

// The outputs of every source. `output` is what was asked for:
//   a template    output_template.hpp; with {iso} in it every iso value has a file, else all of a source are in one
//   a folder      it ends with a slash, which may follow a template, or exists
//   nothing       the current folder
//   "-"           standard output
// In a folder files are named {stem}.EXTENSION; {stem}_{frame:04}.EXTENSION where inputs of several frames have one
// stem, with more digits where a frame needs them, and with _{grid} after that where one frame has several grids.
// EXTENSION is that of the format unless another is given: what is written need not be a mesh.
//
// Fails with ErrorCode::usage for a template that cannot be read, for {grid} where no grid was chosen, for several iso
// values in one file of a format that holds one, for {piece} with several iso values and no {iso}, and as
// check_outputs() does. Folders need not exist.
[[nodiscard]] Result<std::vector<OutputFiles>> name_outputs(std::span<const OutputSource> sources,
                                                            const std::optional<std::string>& output,
                                                            mesh_io::MeshFormat format, std::string_view extension = {},
                                                            const OtherFiles& others = {});

// The same names without check_outputs().
[[nodiscard]] Result<std::vector<OutputFiles>> unchecked_outputs(std::span<const OutputSource> sources,
                                                                 const std::optional<std::string>& output,
                                                                 mesh_io::MeshFormat format,
                                                                 std::string_view extension);

// Whether every file is written once, none of them is read, and none has the name of a manifest; `outputs` are those of
// the sources, and `others` belong to the same set. Compared is the
// place on the disk: links and different ways of writing a path make no difference, as far as they exist by now.
// Files of a format that come in pairs (.gltf and .bin) count both. Fails with ErrorCode::usage; the message names the
// file and whoever would write it. Names with {piece} in them are refused where some numbers of pieces could make two
// of them the same, or the name of an input. Data files that an input's header names are convert::check_mesh_files()'s.
// Takes time as n log n does, and two looks at the disk a file.
[[nodiscard]] Result<void> check_outputs(std::span<const OutputSource> sources, std::span<const OutputFiles> outputs,
                                         mesh_io::MeshFormat format, const OtherFiles& others = {});

// What an input is called without its folder and extension: "a" for dir/a.nii.gz, "sphere" for demo:sphere?size=9,
// "stdin" for standard input.
[[nodiscard]] std::string stem_of(const std::string& input);

}  // namespace isoextract::batch
