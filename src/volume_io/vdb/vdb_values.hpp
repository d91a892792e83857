// The values of a node as a VDB file packs them: what of them is stored, and compressed how.
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
  std::size_t stored_size = 4;  // of each of many values in the file: 2 if saved as half
  std::uint32_t compression = 0;

  [[nodiscard]] bool half() const { return stored_size < value_size; }
};

// Bit i of a node's mask: word i / 64, bit i % 64. Masks lie anywhere in a file.
[[nodiscard]] inline std::uint64_t mask_word(std::span<const std::byte> mask, std::size_t word) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, mask.data() + word * sizeof bits, sizeof bits);
  return bits;
}

// The number of bits that are on.
[[nodiscard]] std::uint32_t count_bits(std::span<const std::byte> mask);

// One node's values, still packed. The parts lie in the window of the cursor that took them.
struct VdbPackedValues {
  std::uint64_t position = 0;            // in the file, for messages
  std::span<const std::byte> active;     // the node's mask, one bit a value
  std::span<const std::byte> selection;  // which inactive value is the second; may be empty: none
  std::span<const std::byte> inactive;   // none, one or two values
  std::span<const std::byte> data;
  std::uint32_t stored = 0;  // the number of values in `data`: all, or the active ones
  bool compressed = false;
  bool inactive_is_background = false;  // where no inactive value is stored: or else it is the background's negative
};

// The most bytes that take_values() takes.
[[nodiscard]] constexpr std::uint64_t max_packed_bytes(std::uint64_t values, std::size_t value_size) {
  constexpr std::uint64_t kOverhead = 1024;
  return 2 * values * value_size + values / 8 + kOverhead;
}

// The values of a node with as many entries as `active` has bits. Everything taken must lie in one window: prepare()
// max_packed_bytes() first. Throws VdbDamaged.
[[nodiscard]] VdbPackedValues take_values(VdbCursor& cursor, std::span<const std::byte> active,
                                          const VdbValueLayout& layout);

// Fills `values`, one for each bit of the mask. For float, double and int32_t. Throws VdbDamaged.
template <class Value>
void unpack_values(const VdbPackedValues& packed, const VdbValueLayout& layout, Value background,
                   std::span<Value> values);

}  // namespace isoextract::volume_io
