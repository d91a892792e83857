// Copies rows of decoded elements into samples. Private to zarr_read.cpp.
#pragma once

#include <cstddef>
#include <functional>

#include "zarr_read.hpp"

namespace isoextract_zarr {

// Copies one row: elements `from_step` bytes apart, samples `to_step` bytes apart. Returns the number of elements
// before the first without an exact sample; `count` if there is none.
using CopyRow = std::function<std::size_t(const std::byte* from, std::ptrdiff_t from_step, std::byte* to,
                                          std::ptrdiff_t to_step, std::size_t count)>;

[[nodiscard]] CopyRow copy_row_of(const DataType& type, const Conversion& conversion);

// Returns the size of a sample that the conversion makes.
[[nodiscard]] std::uint64_t sample_bytes_of(const DataType& type, const Conversion& conversion);

}  // namespace isoextract_zarr
