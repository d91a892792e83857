// Reads a box of an array's samples: only the chunks that the box needs; missing chunks have the fill value.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "volume_reader.hpp"
#include "zarr_metadata.hpp"
#include "zarr_store.hpp"

namespace isoextract_zarr {

struct Array {
  std::string path;  // below the root; "" is the root
  ArrayMetadata metadata;
};

inline constexpr int kNoAxis = -1;

// A box of samples of an array, x fastest in memory.
struct ArrayBox {
  std::array<int, 3> axes{kNoAxis, kNoAxis, kNoAxis};  // the array's axes along x, y and z
  std::array<std::uint64_t, 3> first{};
  std::array<std::uint64_t, 3> count{1, 1, 1};
  std::vector<std::uint64_t> fixed;  // one index per array axis; entries of the axes along x, y and z are ignored
};

struct ChunkCount {
  std::uint64_t read = 0;
  std::uint64_t touched = 0;  // by the box
};

// Returns the type of the samples for elements of a type; ISOEXTRACT_NOT_SCALAR if there is none.
[[nodiscard]] std::int32_t sample_type_of(const DataType& type);

// How elements become samples.
struct Conversion {
  std::int64_t component = 0;  // of complex numbers; or ISOEXTRACT_COMPONENT_LENGTH
  double slope = 1;            // slope and intercept apply only to the numbers that lengths are computed from
  double intercept = 0;
};

// Fills `to` with the box's samples. Throws if a chunk is damaged, or if an integer of 64 bits is not exact as double.
[[nodiscard]] ChunkCount read_box(const Store& store, const Array& array, const ArrayBox& box,
                                  const Conversion& conversion, void* to, const isoextract_plugin_host& host);

// Calls use(key) with the key of every chunk file that the box touches, whether it exists or not. Returns false,
// without calling, if there are more than `most`.
bool visit_chunk_keys(const Array& array, const ArrayBox& box, std::uint64_t most,
                      const std::function<void(const std::string&)>& use);

// Returns how many of the smallest chunks the box touches.
[[nodiscard]] std::uint64_t count_chunks(const Array& array, const ArrayBox& box);

}  // namespace isoextract_zarr
