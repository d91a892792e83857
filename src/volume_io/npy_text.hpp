// Formats the header of NumPy's array files.
#pragma once

#include <string>
#include <string_view>

namespace isoextract::volume_io {

// Returns a header of version 1.0, padded to a multiple of 64 bytes. The format is described at
// https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html.
//
// `type` and `shape` are in Python's notation: "'<f4'", "(2, 3)". The header must be shorter than 64 KiB, because it
// stores its size in 16 bits.
[[nodiscard]] std::string npy_header(std::string_view type, std::string_view shape);

}  // namespace isoextract::volume_io
