// The codecs in the metadata of an array: filters and compressor of Zarr v2, the list of codecs of v3.
#include <algorithm>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "zarr_metadata.hpp"

namespace isoextract_zarr {
namespace {

// Why an array's chunks cannot be decoded.
struct NotSupported {
  std::string what;
};

constexpr std::size_t kMostCodecs = 16;

const Json& configuration_of(const Json& codec) { return member(codec, "configuration"); }

std::string codec_name(const Json& codec, const char* key) {
  // Zarr v3 allows a codec without configuration to be its name alone.
  const std::string name = text_of(codec.is_string() ? codec : member(codec, key));
  if (name.empty()) throw NotSupported{"a codec without a name"};
  return name;
}

std::uint64_t element_of_shuffle(const Json& settings) {
  constexpr std::uint64_t kUsual = 4;  // numcodecs'
  const Json& size = member(settings, "elementsize");
  if (size.is_null()) return kUsual;
  if (!size.is_number_unsigned() || size == 0U || size > 256U) throw NotSupported{"a shuffle of invalid elements"};
  return size.get<std::uint64_t>();
}

void add_codec(const std::string& name, const Json& settings, Pipeline& pipeline) {
  const auto kind = find_codec(name);
  if (!kind) throw NotSupported{fmt::format("the codec '{}'", shown(name))};
  if (is_compressor(*kind) &&
      std::ranges::any_of(pipeline.codecs, [](const Codec& codec) { return is_compressor(codec.kind); })) {
    throw NotSupported{"more than one compressor"};
  }
  if (pipeline.codecs.size() == kMostCodecs) throw NotSupported{fmt::format("more than {} codecs", kMostCodecs)};
  Codec codec{*kind, 1};
  if (*kind == Codec::Kind::shuffle) codec.element = element_of_shuffle(settings);
  if (*kind == Codec::Kind::lzma && !member(settings, "format").is_null() && member(settings, "format") != 1 &&
      member(settings, "format") != 2) {
    throw NotSupported{"lzma without a header"};
  }
  pipeline.codecs.push_back(codec);
}

// numcodecs' delta keeps the type unless astype differs. Without a change, integer differences and their sums wrap
// around, which makes decoding exact.
void check_delta(const Json& settings, const DataType& type) {
  const bool is_integer = type.kind == DataType::Kind::signed_integer || type.kind == DataType::Kind::unsigned_integer;
  const Json& stored = member(settings, "astype");
  if (!is_integer || (!stored.is_null() && stored != member(settings, "dtype"))) {
    throw NotSupported{"the codec 'delta' with a change of type or floating-point numbers"};
  }
}

std::vector<std::size_t> reversed_order(std::size_t axes) {
  std::vector<std::size_t> order(axes);
  std::iota(order.rbegin(), order.rend(), std::size_t{0});
  return order;
}

std::vector<std::size_t> order_of(const Json& order, std::size_t axes) {
  if (order == "C") return {};
  if (order == "F") return reversed_order(axes);
  std::vector<std::size_t> result;
  std::vector<bool> is_used(axes, false);
  for (const std::uint64_t axis : counts_of(order, "the order of a transpose codec")) {
    if (axis >= axes || is_used[axis]) throw ReadError("the transpose codec has no permutation of the axes");
    is_used[axis] = true;
    result.push_back(axis);
  }
  if (result.size() != axes) throw ReadError("the transpose codec has no permutation of the axes");
  return result;
}

// Returns the order that two transpose codecs have together; `second` applies to the result of `first`.
std::vector<std::size_t> composed(const std::vector<std::size_t>& first, std::vector<std::size_t> second) {
  if (first.empty()) return second;
  if (second.empty()) return first;
  for (std::size_t& axis : second) axis = first[axis];
  return second;
}

Pipeline pipeline_of(const Json& codecs, const DataType& type, std::size_t axes, std::optional<Sharding>* sharding);

Sharding sharding_of(const Json& settings, const DataType& type, std::size_t axes) {
  Sharding found;
  found.chunk = counts_of(member(settings, "chunk_shape"), "the shape of chunks in shards");
  if (found.chunk.size() != axes) {
    throw ReadError(fmt::format("expected chunks of {} axes in shards, found {}", axes, found.chunk.size()));
  }
  found.chunks = pipeline_of(member(settings, "codecs"), type, axes, nullptr);
  const DataType offsets{DataType::Kind::unsigned_integer, 8, "uint64"};
  found.index = pipeline_of(member(settings, "index_codecs"), offsets, axes + 1, nullptr);
  if (!found.index.order.empty() || found.index.has_differences || !encoded_size(found.index, 0)) {
    throw NotSupported{"an index of shards with other codecs than 'bytes' and 'crc32c'"};
  }
  const std::string place = text_of(member(settings, "index_location"));
  if (!place.empty() && place != "end" && place != "start") throw NotSupported{"an index inside of shards"};
  found.index_at_end = place != "start";
  return found;
}

void check_inner_chunks(const ArrayMetadata& array) {
  for (std::size_t axis = 0; axis < array.chunk.size(); ++axis) {
    const std::uint64_t inner = array.sharding->chunk[axis];
    if (inner == 0 || array.chunk[axis] % inner != 0) {
      throw ReadError(fmt::format("expected shards of whole chunks, found {} and {} samples along axis {}",
                                  array.chunk[axis], inner, axis));
    }
  }
}

// `sharding`: receives the settings of sharding_indexed; null if the list must not have that codec.
Pipeline pipeline_of(const Json& codecs, const DataType& type, std::size_t axes, std::optional<Sharding>* sharding) {
  if (!codecs.is_array()) throw ReadError("expected a list of codecs");
  Pipeline pipeline;
  bool is_bytes = false;
  for (const Json& codec : codecs) {
    const std::string name = codec_name(codec, "name");
    const Json& settings = configuration_of(codec);
    if (is_bytes) {
      if (sharding != nullptr && *sharding) throw NotSupported{"codecs after sharding_indexed"};
      add_codec(name, settings, pipeline);
    } else if (name == "transpose") {
      if (pipeline.has_differences) throw NotSupported{"a transpose after delta"};
      pipeline.order = composed(pipeline.order, order_of(member(settings, "order"), axes));
    } else if (name == "numcodecs.delta" || name == "delta") {
      check_delta(settings, type);
      if (std::exchange(pipeline.has_differences, true)) throw NotSupported{"the codec 'delta' twice"};
    } else if (name == "bytes" || name == "endian") {
      pipeline.is_big_endian = text_of(member(settings, "endian")) == "big";
      is_bytes = true;
    } else if (name == "sharding_indexed") {
      if (sharding == nullptr) throw NotSupported{"shards inside of shards"};
      if (!pipeline.order.empty() || pipeline.has_differences) throw NotSupported{"codecs before sharding_indexed"};
      *sharding = sharding_of(settings, type, axes);
      is_bytes = true;
    } else {
      // zarrita writes lists without 'bytes', which stand for little-endian numbers.
      add_codec(name, settings, pipeline);
      is_bytes = true;
    }
  }
  return pipeline;
}

}  // namespace

void set_v2_codecs(const Json& metadata, ArrayMetadata& array) {
  try {
    if (member(metadata, "order") == "F") array.pipeline.order = reversed_order(array.shape.size());
    const Json& filters = member(metadata, "filters");
    if (!filters.is_null() && !filters.is_array()) throw ReadError("expected a list of filters");
    for (const Json& filter : filters) {
      const std::string name = codec_name(filter, "id");
      if (name == "delta" && array.pipeline.codecs.empty()) {
        check_delta(filter, array.type);
        if (std::exchange(array.pipeline.has_differences, true)) throw NotSupported{"the filter 'delta' twice"};
      } else {
        add_codec(name, filter, array.pipeline);
      }
    }
    const Json& compressor = member(metadata, "compressor");
    if (!compressor.is_null()) add_codec(codec_name(compressor, "id"), compressor, array.pipeline);
  } catch (const NotSupported& found) {
    array.unsupported_feature = found.what;
  }
}

void set_v3_codecs(const Json& codecs, ArrayMetadata& array) {
  try {
    array.pipeline = pipeline_of(codecs, array.type, array.shape.size(), &array.sharding);
    if (array.sharding) check_inner_chunks(array);
  } catch (const NotSupported& found) {
    array.unsupported_feature = found.what;
    array.sharding.reset();
  }
}

}  // namespace isoextract_zarr
