// Finding out before the work whether its results could be written at its end.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "files/read_files.hpp"

namespace isoextract::convert {

// The files that a job writes for one of its outputs: glTF is two, the model first.
[[nodiscard]] std::vector<std::filesystem::path> mesh_files(const OutputFileJob& output, mesh_io::MeshFormat format);

// Removes those that are there, and names them: an old file of that name would pass for what this run made, among the
// frames of a sequence for example. Data that the old model does not name may be anybody's, and stays.
[[nodiscard]] Result<std::vector<std::string>> remove_old_meshes(const OutputFileJob& output,
                                                                 mesh_io::MeshFormat format, const Context& context);

// The same for pieces that an earlier run had more of: those of the numbers from `first` on, up to the first that is
// not there, that is a link, that is read, or that isoextract does not seem to have written. `output` has kPieceWord in
// its name.
[[nodiscard]] Result<std::vector<std::string>> remove_old_pieces(const OutputFileJob& output, std::size_t first,
                                                                 mesh_io::MeshFormat format,
                                                                 const files::ReadFiles& read, const Context& context);

// "a and b", or "a to z" of more than two names, of which there is at least one.
[[nodiscard]] std::string first_and_last(const std::vector<std::string>& names);

// Gives the files of an earlier run other names (files::set_aside_old_file) in place of removing them, and lists the
// new ones: an old mesh must not pass for one of this run. `output` may have kPieceWord in its name. Files that are
// read and those in `spared` stay.
[[nodiscard]] Result<std::vector<std::string>> set_aside_old_meshes(const OutputFileJob& output,
                                                                    mesh_io::MeshFormat format,
                                                                    const files::ReadFiles& read,
                                                                    std::span<const mesh_io::WrittenFile> spared,
                                                                    const Context& context);

// The input, those that hold its samples or attributes apart, and the job's others. What cannot be told of an input is
// an error when it is read.
void add_read_files(files::ReadFiles& read, const ConversionJob& job, const Context& context);
// A mesh, and its data where those are files of their own.
void add_read_mesh(files::ReadFiles& read, const std::string& path, const Context& context);

// Another file that goes with the job, its report for example: writable, and neither read nor a mesh of the job, nor
// where that goes.
[[nodiscard]] Result<void> check_other_file(const std::filesystem::path& file, const ConversionJob& job,
                                            const Context& context);

// The files of one of the outputs, or of a piece of it, standard output apart: as check_output_file().
[[nodiscard]] Result<void> check_mesh_files(const OutputFileJob& output, mesh_io::MeshFormat format,
                                            const files::ReadFiles& read);

// A file that is written at the end: writable, and not read. Fails with ErrorCode::usage and ErrorCode::output.
[[nodiscard]] Result<void> check_output_file(const std::filesystem::path& path, const files::ReadFiles& read);

}  // namespace isoextract::convert
