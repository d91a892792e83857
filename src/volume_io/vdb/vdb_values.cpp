#include "volume_io/vdb/vdb_values.hpp"

#include <algorithm>
#include <bit>
#include <type_traits>

#include <blosc.h>
#include <fmt/format.h>
#include <zlib.h>

#include "field/sample_type.hpp"

namespace isoextract::volume_io {
namespace {

// The byte before a node's values: how inactive values are stored.
enum InactiveCode : std::uint8_t {
  kBackground,            // all are the background
  kMinusBackground,       // all are its negative
  kOneValue,              // all are one value, which follows
  kBothBackgrounds,       // a mask follows: the negative background where off, the background where on
  kOneValueOrBackground,  // a value and a mask follow: the value where off, the background where on
  kTwoValues,             // two values and a mask follow
  kAllStored,             // they are stored with the active values
};

std::size_t inactive_values(std::uint8_t code) {
  if (code == kTwoValues) return 2;
  return code == kOneValue || code == kOneValueOrBackground ? 1 : 0;
}

bool has_selection(std::uint8_t code) {
  return code == kBothBackgrounds || code == kOneValueOrBackground || code == kTwoValues;
}

// Longest chunk that OpenVDB's own compression makes.
std::uint64_t max_chunk(std::uint64_t bytes) { return 2 * bytes + 512; }

void expand_blosc(const VdbPackedValues& packed, std::span<std::byte> bytes) {
  std::size_t size = 0;
  // blosc_decompress_ctx trusts the lengths in the chunk's header.
  const bool sound = ::blosc_cbuffer_validate(packed.data.data(), packed.data.size(), &size) == 0;
  if (!sound || size != bytes.size()) {
    throw InvalidVdb(fmt::format("expected a valid blosc chunk that decompresses to {} bytes for the node at byte {}",
                                 bytes.size(), packed.position));
  }
  const int got = ::blosc_decompress_ctx(packed.data.data(), bytes.data(), bytes.size(), 1);
  if (got < 0 || static_cast<std::size_t>(got) != bytes.size()) {
    throw InvalidVdb(fmt::format("decompressing the blosc chunk of the node at byte {} failed", packed.position));
  }
}

void expand_zip(const VdbPackedValues& packed, std::span<std::byte> bytes) {
  uLongf size = bytes.size();
  const int done = ::uncompress(reinterpret_cast<Bytef*>(bytes.data()), &size,
                                reinterpret_cast<const Bytef*>(packed.data.data()), packed.data.size());
  if (done != Z_OK || size != bytes.size()) {
    throw InvalidVdb(fmt::format("decompressing the zip chunk of the node at byte {} failed", packed.position));
  }
}

void expand(const VdbPackedValues& packed, const VdbValueLayout& layout, std::span<std::byte> bytes) {
  if (bytes.empty()) return;
  if (!packed.compressed) {
    std::ranges::copy(packed.data, bytes.begin());
  } else if ((layout.compression & kVdbBlosc) != 0) {
    expand_blosc(packed, bytes);
  } else {
    expand_zip(packed, bytes);
  }
}

template <class Value>
Value negative(Value value) {
  if constexpr (std::is_integral_v<Value>) {
    return static_cast<Value>(0U - static_cast<std::make_unsigned_t<Value>>(value));
  } else {
    return -value;
  }
}

// `from` may be at the end of `to`: writes never overtake reads.
template <class Value>
void convert(const std::byte* from, std::size_t stored_size, std::span<Value> to) {
  if constexpr (std::is_floating_point_v<Value>) {
    if (stored_size < sizeof(Value)) {
      for (Value& value : to) {
        field::Half half;
        std::memcpy(&half, from, sizeof half);
        from += sizeof half;
        value = static_cast<float>(half);
      }
      return;
    }
  }
  std::memmove(to.data(), from, to.size_bytes());
}

template <class Value>
struct Inactive {
  Value first;
  Value second;
};

template <class Value>
void fill_inactive(std::span<Value> values, std::uint64_t second, const Inactive<Value>& inactive) {
  if (second == 0) {
    std::ranges::fill(values, inactive.first);
    return;
  }
  for (Value& value : values) {
    value = (second & 1) != 0 ? inactive.second : inactive.first;
    second >>= 1;
  }
}

template <class Value>
Inactive<Value> inactive_of(const VdbPackedValues& packed, Value background) {
  Inactive<Value> inactive{packed.inactive_is_background ? background : negative(background), background};
  if (packed.inactive.size() >= sizeof(Value)) std::memcpy(&inactive.first, packed.inactive.data(), sizeof(Value));
  if (packed.inactive.size() >= 2 * sizeof(Value)) {
    std::memcpy(&inactive.second, packed.inactive.data() + sizeof(Value), sizeof(Value));
  }
  return inactive;
}

// Moves values from `from`, possibly at the end of `values`, to the active entries; fills the other entries with the
// inactive values.
template <class Value>
void spread(const VdbPackedValues& packed, std::size_t stored_size, const std::byte* from,
            const Inactive<Value>& inactive, std::span<Value> values) {
  constexpr std::size_t kBits = 64;
  for (std::size_t word = 0; word < values.size() / kBits; ++word) {
    const std::uint64_t on = mask_word(packed.active, word);
    const std::uint64_t second = packed.selection.empty() ? 0 : mask_word(packed.selection, word);
    for (std::size_t bit = 0; bit < kBits;) {
      const bool active = (on >> bit & 1) != 0;
      const auto run = static_cast<std::size_t>(active ? std::countr_one(on >> bit) : std::countr_zero(on >> bit));
      const std::size_t count = std::min(run, kBits - bit);
      const std::span<Value> places = values.subspan(word * kBits + bit, count);
      if (active) {
        convert(from, stored_size, places);
        from += count * stored_size;
      } else {
        const std::uint64_t rest = second >> bit;
        fill_inactive(places, count < kBits ? rest & ((std::uint64_t{1} << count) - 1) : rest, inactive);
      }
      bit += count;
    }
  }
}

}  // namespace

std::uint32_t count_bits(std::span<const std::byte> mask) {
  int on = 0;
  for (std::size_t word = 0; word < mask.size() / sizeof(std::uint64_t); ++word)
    on += std::popcount(mask_word(mask, word));
  return static_cast<std::uint32_t>(on);
}

VdbPackedValues take_values(VdbCursor& cursor, std::span<const std::byte> active, const VdbValueLayout& layout) {
  VdbPackedValues packed;
  packed.position = cursor.position();
  packed.active = active;
  const auto code = cursor.read_value<std::uint8_t>();
  if (code > kAllStored) {
    throw InvalidVdb(
        fmt::format("expected a code from 0 to {} for the inactive values of the node at byte {}, found {}",
                    static_cast<int>(kAllStored), packed.position, code));
  }
  packed.inactive_is_background = code == kBackground;
  packed.inactive = cursor.take(inactive_values(code) * layout.value_size);
  if (has_selection(code)) packed.selection = cursor.take(active.size());
  const bool only_active = (layout.compression & kVdbActiveMask) != 0 && code != kAllStored;
  packed.stored = only_active ? count_bits(active) : static_cast<std::uint32_t>(8 * active.size());
  const std::uint64_t expected = packed.stored * layout.stored_size;
  if ((layout.compression & (kVdbZip | kVdbBlosc)) == 0) {
    packed.data = cursor.take(expected);
    return packed;
  }
  // Without values to store, OpenVDB writes nothing for halves, but a size for other types.
  if (packed.stored == 0 && layout.half()) return packed;

  // Positive: compressed bytes. Zero or negative: -size uncompressed bytes.
  const auto size = cursor.read_value<std::int64_t>();
  packed.compressed = size > 0;
  const std::uint64_t length =
      packed.compressed ? static_cast<std::uint64_t>(size) : 0 - static_cast<std::uint64_t>(size);
  if (packed.compressed && length > max_chunk(expected)) {
    throw InvalidVdb(
        fmt::format("the values of the node at byte {} have {} bytes; expected at most {} compressed bytes for them, "
                    "found {}",
                    packed.position, expected, max_chunk(expected), length));
  }
  if (!packed.compressed && length != expected) {
    throw InvalidVdb(fmt::format("expected {} bytes of uncompressed values of the node at byte {}, found {}", expected,
                                 packed.position, length));
  }
  packed.data = cursor.take(length);
  return packed;
}

template <class Value>
void unpack_values(const VdbPackedValues& packed, const VdbValueLayout& layout, Value background,
                   std::span<Value> values) {
  // Decompresses to the end of `values`, from where they can be moved forward in place.
  const std::span<std::byte> stored = std::as_writable_bytes(values).last(packed.stored * layout.stored_size);
  expand(packed, layout, stored);
  if (packed.stored == values.size()) {
    if (layout.half()) convert(stored.data(), layout.stored_size, values);
  } else {
    spread(packed, layout.stored_size, stored.data(), inactive_of(packed, background), values);
  }
}

template void unpack_values(const VdbPackedValues&, const VdbValueLayout&, float, std::span<float>);
template void unpack_values(const VdbPackedValues&, const VdbValueLayout&, double, std::span<double>);
template void unpack_values(const VdbPackedValues&, const VdbValueLayout&, std::int32_t, std::span<std::int32_t>);

}  // namespace isoextract::volume_io
