// The one door to volumes: which format an input is, what is in it, and reading it. The formats are behind it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::volume_io {

// Whether an input is a volume beyond doubt: demo:NAME, of the format or the raw layout that `options` name, or by its
// content. An array of numbers in rows may be one of particles all the same. Reads the beginning of the file.
[[nodiscard]] Result<bool> is_surely_volume(const std::string& input, const ReadOptions& options,
                                            const Context& context);

// Whether a file is named like those of a format, whatever the case.
[[nodiscard]] bool has_volume_extension(const std::filesystem::path& path);

// What a file is that no format here reads, where it is of a known kind: an error that says so, and what converts it.
[[nodiscard]] std::optional<Error> known_but_unread(const std::filesystem::path& path, const Context& context);

// `input` is a path, "-" for standard input (files::InputFile tells how it is kept) or demo:NAME. Never reads samples.
[[nodiscard]] Result<std::vector<GridInfo>> list_grids(const std::string& input, const ReadOptions& options,
                                                       const Context& context);

// The label of the grid that ReadOptions::grid names, which is set; of a grid that a plug-in reads, that name. Fails as
// read_volume where there is no such grid, or several. Never reads samples.
[[nodiscard]] Result<std::string> grid_label(const std::string& input, const ReadOptions& options,
                                             const Context& context);

// What the format says of itself that an input would be read as. Reads the beginning of the file.
[[nodiscard]] Result<FormatDescription> format_of(const std::string& input, const ReadOptions& options,
                                                  const Context& context);

// How many volumes, such as time steps, read_volume can choose from by ReadOptions::volume: 1 for most files. What
// `options` choose is not looked at. Never reads samples.
[[nodiscard]] Result<std::uint64_t> count_volumes(const std::string& input, const ReadOptions& options,
                                                  const Context& context);

// The files that read_volume would read: `input`, and those that hold the samples where its header says so. A file may
// be named twice. Never reads samples.
[[nodiscard]] Result<std::vector<std::filesystem::path>> list_input_files(const std::string& input,
                                                                          const ReadOptions& options,
                                                                          const Context& context);

// Reads one grid. Fails with ErrorCode::input (unreadable, unsupported, no such grid or volume; the hint lists what
// there is where a choice is missing or wrong) or ErrorCode::usage (options that do not go with the format). Samples
// that are no mapping of a file stay reserved in the context's memory for as long as they live.
[[nodiscard]] Result<field::ScalarField> read_volume(const std::string& input, const ReadOptions& options,
                                                     const Context& context);

// Asked after each work on a field's samples: fails with ErrorCode::input where the file that they are mapped from was
// cut off meanwhile, or could not be read. What came of the work is then to be thrown away.
[[nodiscard]] Result<void> check_not_lost(const field::ScalarField& field);

}  // namespace isoextract::volume_io
