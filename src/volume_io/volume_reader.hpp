// The entry point for reading volumes: detects the format of an input, lists its contents, and reads it. Listing and
// counting reads no samples, except by plug-ins whose libraries read whole files, such as VTK's.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"
#include "files/file_part.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::volume_io {

// Returns the position of the colon in FILE:/PATH, which names a grid of a file: FILE exists, and no file has the whole
// input as its name. All functions with ReadOptions take such inputs.
[[nodiscard]] std::optional<std::size_t> find_inner_path(const std::string& input);

// Returns whether the folder is an input, such as a Zarr array or a series of DICOM files, instead of a folder of
// inputs. Reads the starts of some of its files.
[[nodiscard]] bool is_volume_folder(const std::filesystem::path& path, const Context& context);

// Returns whether the input is a pattern or folder of single pictures, which are the slices of one volume: images of
// the same format, at least two. Files that hold volumes are a sequence, not a stack. Opens at most two of the files.
[[nodiscard]] bool is_slice_stack(const std::string& input, const Context& context);

// Returns whether the file's extension is that of a format of single pictures, ignoring case.
[[nodiscard]] bool has_picture_extension(const std::filesystem::path& path);

// Returns whether an input is certainly a volume: by its demo: prefix, by the format or raw layout in `options`, or by
// its content. Also returns true for every NPY array: the caller must check whether an array with one row per particle
// holds particles. Reads the start of the file.
[[nodiscard]] Result<bool> is_certainly_volume(const std::string& input, const ReadOptions& options,
                                               const Context& context);

// Returns whether the file name has the extension of a volume format, ignoring case.
[[nodiscard]] bool has_volume_extension(const std::filesystem::path& path);

// Returns an error for a file of a known format that is not supported; it names a program that converts the file.
// Returns nothing for other files.
[[nodiscard]] std::optional<Error> unsupported_format_error(const std::filesystem::path& path, const Context& context);

// Lists the grids of an input: a path, "-" for standard input (files::InputFile keeps its bytes) or demo:NAME.
[[nodiscard]] Result<std::vector<GridInfo>> list_grids(const std::string& input, const ReadOptions& options,
                                                       const Context& context);

// Returns the label of the grid selected by ReadOptions::grid, which must be set; for a grid that a plug-in reads, the
// given name. Fails as read_volume() does if no grid or several grids match.
[[nodiscard]] Result<std::string> grid_label(const std::string& input, const ReadOptions& options,
                                             const Context& context);

// Returns the description of the format that the input would be read as. Reads the start of the file.
[[nodiscard]] Result<FormatDescription> format_of(const std::string& input, const ReadOptions& options,
                                                  const Context& context);

// Returns the number of volumes, such as time steps, that ReadOptions::volume can select from; 1 for most files.
// Ignores ReadOptions::volume. Returns the count of the grid in ReadOptions::grid if given, else the largest of all
// grids.
[[nodiscard]] Result<std::uint64_t> count_volumes(const std::string& input, const ReadOptions& options,
                                                  const Context& context);

// Lists the files that read_volume() would read: `input` and data files named in its header. A file may be listed
// twice.
[[nodiscard]] Result<std::vector<std::filesystem::path>> list_input_files(const std::string& input,
                                                                          const ReadOptions& options,
                                                                          const Context& context);

// Lists the same files with the bytes of each that the selected volume depends on; a part without ranges is its whole
// file.
[[nodiscard]] Result<std::vector<files::FilePart>> list_input_parts(const std::string& input,
                                                                    const ReadOptions& options, const Context& context);

// Reads one grid. Fails with ErrorCode::usage if options do not fit the format. Fails with ErrorCode::input if the file
// is unreadable or unsupported, or if a selection is missing or wrong; the hint lists the possible ones. The memory
// of samples that are not mapped from a file stays reserved in the context for as long as they live.
[[nodiscard]] Result<field::ScalarField> read_volume(const std::string& input, const ReadOptions& options,
                                                     const Context& context);

// Call after each use of a field's samples: fails with ErrorCode::input if their mapped file was truncated or could not
// be read meanwhile. Results computed from the samples must then be discarded.
[[nodiscard]] Result<void> check_mapping_intact(const field::ScalarField& field);

}  // namespace isoextract::volume_io
