// Inputs that are compressed as a whole (gzip, xz, zstd, bzip2), and archives (zip, tar) of the files of one input,
// such as slices. A plug-in unpacks them in a child process into memory (files/unpacked_files.hpp), from where every
// reader reads them.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"

namespace isoextract::plugin_host {

// Selects whether gzip files are unpacked; files named .tgz or .tar.* always are. Readers that decompress gzip files
// while reading need less memory.
enum class GzipFiles { keep, unpack };

// Returns the path under which readers find an input: its own, unless its content is compressed or it is an archive. An
// archive with several files becomes a folder; an archive with one file becomes that file. A zip file is an archive
// only if it is named .zip, and holds no Zarr arrays, which have a reader of their own. The unpacked files are kept for
// as long as the context lives. Returns the input itself if it is no file or cannot be opened: its reader reports that.
//
// Fails with ErrorCode::unavailable if the plug-in is missing, with ErrorCode::input for damaged data, and as
// files::UnpackedFiles::make() does.
[[nodiscard]] Result<std::string> unpacked_input(const std::string& input, GzipFiles gzip, const Context& context);

// Returns the error for an archive whose folder of unpacked files is not one input. `input` starts the message, which
// names files of the folder: those of which is_input() is true, or all if there is none.
[[nodiscard]] Error not_one_input(const std::string& input, const std::filesystem::path& folder,
                                  const std::function<bool(const std::filesystem::path&)>& is_input);

// Returns whether a folder has no files, at any depth, of which is_input() is true.
[[nodiscard]] bool has_no_input(const std::filesystem::path& folder,
                                const std::function<bool(const std::filesystem::path&)>& is_input);

}  // namespace isoextract::plugin_host
