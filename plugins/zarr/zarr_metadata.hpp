// The metadata of one array, of Zarr v2 (.zarray) or v3 (zarr.json), as one description.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "zarr_codecs.hpp"

namespace isoextract_zarr {

using Json = nlohmann::json;

struct DataType {
  enum class Kind { unsigned_integer, signed_integer, floating, complex, other };
  Kind kind = Kind::other;
  std::uint64_t size = 0;  // bytes of an element
  std::string name;        // "uint16"

  // Returns the size of one number; a complex element has two.
  [[nodiscard]] std::uint64_t number() const { return kind == Kind::complex ? size / 2 : size; }
};

// The chunks inside a shard ("sharding_indexed").
struct Sharding {
  std::vector<std::uint64_t> chunk;
  Pipeline chunks;
  Pipeline index;
  bool index_at_end = true;
};

struct ArrayMetadata {
  std::vector<std::uint64_t> shape;
  std::vector<std::uint64_t> chunk;  // of a sharded array: the shape of a shard
  DataType type;
  Bytes fill;  // one element in native byte order
  std::string chunk_prefix;
  char separator = '/';
  Pipeline pipeline;
  std::optional<Sharding> sharding;
  std::vector<std::string> dimension_names;  // as many as there are axes, or none
  std::string unsupported_feature;           // "the codec 'zfp'"; empty if there is none

  // Returns the key of a chunk below the array's path.
  [[nodiscard]] std::string chunk_key(const std::vector<std::uint64_t>& chunk_index) const;
  // Returns the shape of the smallest chunks: the chunks in shards if the array has shards.
  [[nodiscard]] const std::vector<std::uint64_t>& inner_chunk() const { return sharding ? sharding->chunk : chunk; }
};

// Parses the metadata of an array. Throws if they are not valid; codecs and types that are not supported only set
// `unsupported_feature`.
[[nodiscard]] ArrayMetadata parse_v2_array(const Json& metadata, const Json& attributes);
[[nodiscard]] ArrayMetadata parse_v3_array(const Json& metadata);

// Sets the codecs of an array whose shape and type are known. Private to zarr_metadata.cpp and zarr_codec_chain.cpp.
void set_v2_codecs(const Json& metadata, ArrayMetadata& array);
void set_v3_codecs(const Json& codecs, ArrayMetadata& array);

// Returns a member of an object; a null value if there is none.
[[nodiscard]] const Json& member(const Json& object, const char* key);
[[nodiscard]] std::string text_of(const Json& value);
// Returns the integers of a JSON array; throws unless all are 0 or more. `what` names the array in messages.
[[nodiscard]] std::vector<std::uint64_t> counts_of(const Json& value, const char* what);
// Returns the numbers of an array; nothing unless it has exactly `count` numbers, all finite.
[[nodiscard]] std::optional<std::vector<double>> numbers_of(const Json& value, std::size_t count);

// Returns `first` times all factors; throws if the product has more than 63 bits.
[[nodiscard]] std::uint64_t product_of(const std::vector<std::uint64_t>& factors, std::uint64_t first);

}  // namespace isoextract_zarr
