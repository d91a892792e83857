// Formats the header of NumPy's array files.
#pragma once

#include <string>
#include <string_view>

namespace isoextract::volume_io {

// Returns a version 1.0 header, padded to a multiple of 64 bytes:
// https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html `type` and `shape` are in Python's notation:
// "'<f4'", "(2, 3)". They must be short, as the header stores its size in 16 bits.
[[nodiscard]] std::string npy_header(std::string_view type, std::string_view shape);

}  // namespace isoextract::volume_io
