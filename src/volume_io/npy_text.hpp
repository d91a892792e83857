// The header of NumPy's array files.
#pragma once

#include <string>
#include <string_view>

namespace isoextract::volume_io {

// Version 1.0, with a multiple of 64 bytes: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
// `type` and `shape` are as Python writes them: "'<f4'", "(2, 3)". Both are short: the header says its size in 16 bits.
[[nodiscard]] std::string npy_header(std::string_view type, std::string_view shape);

}  // namespace isoextract::volume_io
