// Calls of the compression libraries. Private to zarr_codecs.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "zarr_codecs.hpp"

namespace isoextract_zarr {

// Throws if `from` cannot decompress to `bytes` bytes; call it before reserving memory for them. Accepts any bz2 and
// lzma data.
void check_plausible(Codec::Kind kind, std::span<const std::byte> from, std::uint64_t bytes);

// Fills `to`. Throws if the bytes are damaged, or decompress to more or fewer.
void decompress(Codec::Kind kind, std::span<const std::byte> from, std::span<std::byte> to);

// Reads a little-endian number on any machine.
template <class T>
T little_endian(std::span<const std::byte> bytes, std::size_t at) {
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    value = static_cast<T>(value | static_cast<T>(static_cast<T>(std::to_integer<T>(bytes[at + i])) << (8 * i)));
  }
  return value;
}

}  // namespace isoextract_zarr
