// Checks before a conversion whether its results can be written, and removes or renames the output files of earlier
// runs.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "files/input_file_set.hpp"

namespace isoextract::convert {

// Returns the files that a job writes for one output: two for .gltf, the model first. Placeholders stay in the names.
[[nodiscard]] std::vector<std::filesystem::path> mesh_files(const OutputFileJob& output, mesh_io::MeshFormat format);

// Removes the output's old files, which would pass for results of this run, and returns their names. A glTF data file
// stays unless the old model names it: it may belong to another model. Fails with ErrorCode::output.
[[nodiscard]] Result<std::vector<std::string>> remove_old_meshes(const OutputFileJob& output,
                                                                 mesh_io::MeshFormat format, const Context& context);

// Removes the files of bodies from number `first` on, left by an earlier run that had more bodies, and returns their
// names. Stops at the first number whose file does not exist, is a link, is an input of this run, or was not written by
// isoextract, and after kMaxPieceFiles. The name of `output` contains kPiecePlaceholder. Fails with ErrorCode::output.
[[nodiscard]] Result<std::vector<std::string>> remove_old_pieces(const OutputFileJob& output, std::size_t first,
                                                                 mesh_io::MeshFormat format,
                                                                 const files::InputFileSet& read,
                                                                 const Context& context);

// Returns "a", "a and b", or "a to z" for more than two names. `names` is not empty.
[[nodiscard]] std::string first_and_last(const std::vector<std::string>& names);

// Adds to the error of a conversion how many files it wrote before, and the first and last name: these files stay. Does
// not change an ErrorCode::cancelled.
[[nodiscard]] Error with_kept_files(Error error, const std::vector<mesh_io::WrittenFile>& files);

// Renames the output's old files (files::rename_old_file), which would pass for results of this run, and returns the
// new names. Files that are read and files in `spared` keep their names.
//
// Renames the files of bodies from number 1 on if the name of `output` contains kPiecePlaceholder, and then stops as
// remove_old_pieces() does. Fails with ErrorCode::output.
[[nodiscard]] Result<std::vector<std::string>> rename_old_meshes(const OutputFileJob& output,
                                                                 mesh_io::MeshFormat format,
                                                                 const files::InputFileSet& read,
                                                                 std::span<const mesh_io::WrittenFile> spared,
                                                                 const Context& context);

// Adds the files that the job reads: the input, the files that hold its samples or attributes, and the table of label
// names. If the input is standard input, the first of these is the file that standard input comes from. If the input
// cannot be examined, does not fail: reading the input fails later.
void add_read_files(files::InputFileSet& read, const ConversionJob& job, const Context& context);
// Adds a mesh file and its data files.
void add_read_mesh(files::InputFileSet& read, const std::string& path, const Context& context);

// Checks a file that the job writes besides its meshes, such as its report. Checks that `file` is
// writable, that the job does not read it, and that no mesh or body of the job may be written to it. Fails
// with ErrorCode::usage or ErrorCode::output.
[[nodiscard]] Result<void> check_extra_output(const std::filesystem::path& file, const ConversionJob& job,
                                              const Context& context);

// Checks the files of one output, or of one body in it, as check_output_file() does. Standard output passes.
[[nodiscard]] Result<void> check_mesh_files(const OutputFileJob& output, mesh_io::MeshFormat format,
                                            const files::InputFileSet& read);

// Checks that the run can write the file `path` and does not read it. Pipes and devices count as writable and are not
// opened. Fails with ErrorCode::usage if the run reads the file, and with ErrorCode::output if it is not writable.
[[nodiscard]] Result<void> check_output_file(const std::filesystem::path& path, const files::InputFileSet& read);

}  // namespace isoextract::convert
