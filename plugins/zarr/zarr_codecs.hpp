// The codecs of Zarr chunks (Zarr v3 core specification, "Codecs"; numcodecs for v2). Every decoder writes exactly the
// bytes that the chunk must have, or throws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "zarr_store.hpp"

namespace isoextract_zarr {

// From bytes to bytes.
struct Codec {
  enum class Kind { deflate, zstd, blosc, lz4, bz2, lzma, shuffle, crc32c };
  Kind kind = Kind::deflate;  // deflate: zlib and gzip, told apart by their header
  std::uint64_t element = 1;  // shuffle: bytes of one element
};

// Returns the codec of a name in numcodecs or Zarr v3; nothing if it is not supported.
[[nodiscard]] std::optional<Codec::Kind> find_codec(const std::string& name);
[[nodiscard]] bool is_compressor(Codec::Kind kind);

// How a chunk becomes bytes, in the order of writing. Reading goes backward.
struct Pipeline {
  std::vector<std::size_t> order;  // order[i]: the array's axis that is stored as axis i; empty: 0, 1, 2, ...
  bool has_differences = false;    // of successive stored elements (numcodecs' delta)
  bool is_big_endian = false;
  std::vector<Codec> codecs;  // at most one of them compresses
};

// Buffers of one thread, whose memory is reserved in the host until this object ends.
class Workspace {
 public:
  explicit Workspace(const isoextract_plugin_host& host) : memory_(host) {}

  // Returns the first `bytes` of buffer 0 or 1; its content is lost if it has to grow.
  std::span<std::byte> buffer(std::size_t number, std::uint64_t bytes);

 private:
  isoextract_plugin::HostMemory memory_;
  Bytes buffers_[2];
};

// Returns the largest plausible encoded size of `bytes` decoded bytes; no encoder writes more.
[[nodiscard]] std::uint64_t most_encoded(std::uint64_t bytes);

// Returns the encoded size of `bytes` decoded bytes; nothing if the pipeline compresses.
[[nodiscard]] std::optional<std::uint64_t> encoded_size(const Pipeline& pipeline, std::uint64_t bytes);

// Undoes the codecs of a pipeline and the byte order of numbers of `number` bytes, but not differences and axis order.
// `encoded` is in buffer 0. Returns `bytes` bytes in one of the buffers. Throws if the chunk does not have that size.
[[nodiscard]] std::span<std::byte> decode(const Pipeline& pipeline, std::span<std::byte> encoded, std::uint64_t bytes,
                                          std::uint64_t number, Workspace& space);

// Replaces differences by the sums from the first element on; elements have 1, 2, 4 or 8 bytes.
void sum_differences(std::span<std::byte> bytes, std::uint64_t element);

// Returns the CRC-32C (Castagnoli) of bytes.
[[nodiscard]] std::uint32_t crc32c(std::span<const std::byte> bytes);

}  // namespace isoextract_zarr
