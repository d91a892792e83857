// The values of a node as stored in a VDB file: which of them are stored, and how they are compressed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "volume_io/vdb/vdb_cursor.hpp"

namespace isoextract::volume_io {

// VDB's compression flags.
inline constexpr std::uint32_t kVdbZip = 1;
inline constexpr std::uint32_t kVdbActiveMask = 2;
inline constexpr std::uint32_t kVdbBlosc = 4;

struct VdbValueLayout {
  std::size_t value_size = 4;   // in memory, and of a single value in the file
  std::size_t stored_size = 4;  // of each value in a node's array: 2 if saved as half
  std::uint32_t compression = 0;

  [[nodiscard]] bool half() const { return stored_size < value_size; }
};

// Returns word `word` of a mask; bit i of the mask is bit i % 64 of word i / 64. The mask may be unaligned.
[[nodiscard]] inline std::uint64_t mask_word(std::span<const std::byte> mask, std::size_t word) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, mask.data() + word * sizeof bits, sizeof bits);
  return bits;
}

// Returns the number of set bits.
[[nodiscard]] std::uint32_t count_bits(std::span<const std::byte> mask);

// The compressed values of one node. The spans point into the cursor's window.
struct VdbPackedValues {
  std::uint64_t position = 0;            // in the file, for messages
  std::span<const std::byte> active;     // the node's active mask, one bit a value
  std::span<const std::byte> selection;  // mask of inactive voxels with the second inactive value; may be empty
  std::span<const std::byte> inactive;   // zero, one or two inactive values
  std::span<const std::byte> data;
  std::uint32_t stored = 0;  // number of values in `data`: all, or the active ones
  bool compressed = false;
  bool inactive_is_background = false;  // first inactive value if none is stored: the background, else its negative
};

// Returns the largest number of bytes that take_values() reads.
[[nodiscard]] constexpr std::uint64_t max_packed_bytes(std::uint64_t values, std::size_t value_size) {
  constexpr std::uint64_t kOverhead = 1024;
  return 2 * values * value_size + values / 8 + kOverhead;
}

// Reads the values of a node with as many entries as `active` has bits. They must lie in one window: call prepare()
// with max_packed_bytes() first. Throws InvalidVdb.
[[nodiscard]] VdbPackedValues take_values(VdbCursor& cursor, std::span<const std::byte> active,
                                          const VdbValueLayout& layout);

// Fills `values`, one for each bit of the mask. For float, double and int32_t. Throws InvalidVdb.
template <class Value>
void unpack_values(const VdbPackedValues& packed, const VdbValueLayout& layout, Value background,
                   std::span<Value> values);

}  // namespace isoextract::volume_io
