// The window of a compressed file's decoder: the last unpacked bytes, which it keeps to copy repetitions from them.
#pragma once

#include <cstdint>
#include <string>

namespace isoextract_archive {

// Returns the bytes of the window that the first stream of an xz or zstd file states, at most the size of the content
// if the stream states it. Returns 0 for other formats and for headers that are damaged or unknown. Later streams of a
// file may state other windows.
[[nodiscard]] std::uint64_t stated_window(const std::string& path);

}  // namespace isoextract_archive
