#include "zarr_read.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "zarr_elements.hpp"

namespace isoextract_zarr {
namespace {

using Indices = std::vector<std::uint64_t>;

// A range of samples along every axis of an array.
struct Region {
  Indices begin;
  Indices end;
};

// The chunks of one size that a region touches, numbered in C order.
struct ChunkRange {
  Indices first;
  Indices count;

  // Throws if there are 2^63 chunks or more.
  [[nodiscard]] std::uint64_t size() const { return product_of(count, 1); }
  [[nodiscard]] Indices at(std::uint64_t number) const {
    Indices index(first);
    for (std::size_t axis = first.size(); axis-- > 0;) {
      index[axis] += number % count[axis];
      number /= count[axis];
    }
    return index;
  }
};

Region region_of(const Array& array, const ArrayBox& box) {
  Region region{box.fixed, box.fixed};
  region.begin.resize(array.metadata.shape.size());
  region.end.resize(array.metadata.shape.size());
  for (std::uint64_t& end : region.end) ++end;
  for (std::size_t i = 0; i < 3; ++i) {
    if (box.axes[i] == kNoAxis) continue;
    const auto axis = static_cast<std::size_t>(box.axes[i]);
    region.begin[axis] = box.first[i];
    region.end[axis] = box.first[i] + box.count[i];
  }
  return region;
}

ChunkRange chunks_of(const Region& region, const Indices& chunk) {
  ChunkRange range{region.begin, region.begin};
  for (std::size_t axis = 0; axis < chunk.size(); ++axis) {
    range.first[axis] = region.begin[axis] / chunk[axis];
    range.count[axis] = (region.end[axis] - 1) / chunk[axis] + 1 - range.first[axis];
  }
  return range;
}

// Returns the part of a region that lies in the chunk at `index`. `chunk`: size of a chunk.
Region within_chunk(const Region& region, const Indices& chunk, const Indices& index) {
  Region part = region;
  for (std::size_t axis = 0; axis < chunk.size(); ++axis) {
    const std::uint64_t begin = index[axis] * chunk[axis];
    part.begin[axis] = std::max(region.begin[axis], begin);
    part.end[axis] = std::min(region.end[axis], begin + chunk[axis]);
  }
  return part;
}

struct ShardEntry {
  std::uint64_t offset;
  std::uint64_t bytes;
};

// Reads chunks into one box. Several threads call read_file() and decode_chunk() at once, each for another chunk.
class BoxReader {
 public:
  BoxReader(const Store& store, const Array& array, const ArrayBox& box, const Conversion& conversion, void* to,
            const isoextract_plugin_host& host)
      : store_(store),
        array_(array),
        metadata_(array.metadata),
        box_(box),
        to_(static_cast<std::byte*>(to)),
        host_(host),
        copy_row_(copy_row_of(metadata_.type, conversion)),
        sample_bytes_(sample_bytes_of(metadata_.type, conversion)),
        component_offset_(std::max<std::int64_t>(conversion.component, 0) *
                          static_cast<std::int64_t>(metadata_.type.number())),
        chunk_bytes_(product_of(metadata_.inner_chunk(), metadata_.type.size)),
        spaces_([&host] { return Workspace(host); }) {}

  ChunkCount read() {
    const Region region = region_of(array_, box_);
    const ChunkRange range = chunks_of(region, metadata_.chunk);
    tbb::parallel_for(std::uint64_t{0}, range.size(), [&](std::uint64_t number) {
      isoextract_plugin::check_cancelled(host_);
      const Indices index = range.at(number);
      const std::string key = join(array_.path, metadata_.chunk_key(index));
      try {
        read_file(key, within_chunk(region, metadata_.chunk, index), index);
      } catch (const ReadError& error) {
        throw ReadError(fmt::format("chunk '{}': {}", shown(key), error.what()));
      }
    });
    return {read_, count_chunks(array_, box_)};
  }

 private:
  void read_file(const std::string& key, const Region& region, const Indices& index) {
    const std::unique_ptr<Value> value = store_.find(key);
    if (value == nullptr) return fill(region);
    if (metadata_.sharding) return read_shard(*value, region, index);
    decode_chunk(*value, {0, value->size()}, metadata_.pipeline, region, index);
  }

  void read_shard(const Value& value, const Region& region, const Indices& index) {
    const Sharding& sharding = *metadata_.sharding;
    Indices inside(metadata_.chunk);
    for (std::size_t axis = 0; axis < inside.size(); ++axis) inside[axis] /= sharding.chunk[axis];
    const std::vector<ShardEntry> entries = read_index(value, inside);
    const ChunkRange range = chunks_of(region, sharding.chunk);
    tbb::parallel_for(std::uint64_t{0}, range.size(), [&](std::uint64_t number) {
      isoextract_plugin::check_cancelled(host_);
      const Indices chunk = range.at(number);
      std::uint64_t entry = 0;
      for (std::size_t axis = 0; axis < chunk.size(); ++axis) {
        entry = entry * inside[axis] + (chunk[axis] - index[axis] * inside[axis]);
      }
      const Region part = within_chunk(region, sharding.chunk, chunk);
      constexpr std::uint64_t kMissing = std::numeric_limits<std::uint64_t>::max();
      if (entries[entry].offset == kMissing && entries[entry].bytes == kMissing) return fill(part);
      decode_chunk(value, entries[entry], sharding.chunks, part, chunk);
    });
  }

  // Returns the offsets and sizes of the chunks in a shard, in C order.
  std::vector<ShardEntry> read_index(const Value& value, const Indices& inside) {
    const Sharding& sharding = *metadata_.sharding;
    const std::uint64_t bytes = product_of(inside, sizeof(ShardEntry));
    const std::uint64_t stored = *encoded_size(sharding.index, bytes);
    if (stored > value.size()) {
      throw ReadError(fmt::format("expected a shard with an index of {} bytes, found {} bytes", stored, value.size()));
    }
    Workspace space(host_);
    const std::span encoded = space.buffer(0, stored);
    value.read(sharding.index_at_end ? value.size() - stored : 0, encoded);
    const std::span decoded = decode(sharding.index, encoded, bytes, sizeof(std::uint64_t), space);
    std::vector<ShardEntry> entries(bytes / sizeof(ShardEntry));
    std::memcpy(entries.data(), decoded.data(), bytes);
    return entries;
  }

  void decode_chunk(const Value& value, const ShardEntry& place, const Pipeline& pipeline, const Region& region,
                    const Indices& index) {
    if (place.bytes > most_encoded(chunk_bytes_)) {
      throw ReadError(fmt::format("expected at most {} stored bytes for {} decoded ones, found {}",
                                  most_encoded(chunk_bytes_), chunk_bytes_, place.bytes));
    }
    if (place.offset > value.size() || value.size() - place.offset < place.bytes) {
      throw ReadError(fmt::format("expected {} bytes from byte {} on, found {} bytes in all", place.bytes, place.offset,
                                  value.size()));
    }
    Workspace& space = spaces_.local();
    const std::span encoded = space.buffer(0, place.bytes);
    value.read(place.offset, encoded);
    const DataType& type = metadata_.type;
    const std::span<std::byte> elements = decode(pipeline, encoded, chunk_bytes_, type.number(), space);
    if (pipeline.has_differences) sum_differences(elements, type.size);
    copy(elements.data(), pipeline.order, region, index);
    ++read_;
  }

  // Copies those elements of a chunk that are in a region. `index`: the chunk's.
  void copy(const std::byte* elements, const std::vector<std::size_t>& order, const Region& region,
            const Indices& index) const {
    const Indices& chunk = metadata_.inner_chunk();
    // Bytes from one element to the next along each axis of the array.
    std::vector<std::ptrdiff_t> steps(chunk.size());
    auto step = static_cast<std::ptrdiff_t>(metadata_.type.size);
    for (std::size_t i = chunk.size(); i-- > 0;) {
      const std::size_t axis = order.empty() ? i : order[i];
      steps[axis] = step;
      step *= static_cast<std::ptrdiff_t>(chunk[axis]);
    }
    const std::byte* from = elements;
    for (std::size_t axis = 0; axis < chunk.size(); ++axis) {
      from += static_cast<std::ptrdiff_t>(region.begin[axis] - index[axis] * chunk[axis]) * steps[axis];
    }
    write(from, steps, region);
  }

  void fill(const Region& region) const {
    write(metadata_.fill.data(), std::vector<std::ptrdiff_t>(region.begin.size()), region);
  }

  void write(const std::byte* from, const std::vector<std::ptrdiff_t>& steps, const Region& region) const {
    std::array<std::ptrdiff_t, 3> from_step{};
    std::array<std::uint64_t, 3> begin{};
    std::array<std::uint64_t, 3> count{1, 1, 1};
    for (std::size_t i = 0; i < 3; ++i) {
      if (box_.axes[i] == kNoAxis) continue;
      const auto axis = static_cast<std::size_t>(box_.axes[i]);
      from_step[i] = steps[axis];
      begin[i] = region.begin[axis] - box_.first[i];
      count[i] = region.end[axis] - region.begin[axis];
    }
    from += component_offset_;
    for (std::uint64_t z = 0; z < count[2]; ++z) {
      for (std::uint64_t y = 0; y < count[1]; ++y) {
        const std::byte* row =
            from + static_cast<std::ptrdiff_t>(z) * from_step[2] + static_cast<std::ptrdiff_t>(y) * from_step[1];
        const std::uint64_t sample = ((begin[2] + z) * box_.count[1] + begin[1] + y) * box_.count[0] + begin[0];
        const std::size_t copied = copy_row_(row, from_step[0], to_ + sample * sample_bytes_,
                                             static_cast<std::ptrdiff_t>(sample_bytes_), count[0]);
        if (copied == count[0]) continue;
        throw ReadError(
            fmt::format("expected integers that a double represents exactly, such as all up to 2^53, "
                        "found another at sample ({}, {}, {})",
                        box_.first[0] + begin[0] + copied, box_.first[1] + begin[1] + y, box_.first[2] + begin[2] + z));
      }
    }
  }

  const Store& store_;
  const Array& array_;
  const ArrayMetadata& metadata_;
  const ArrayBox& box_;
  std::byte* to_;
  const isoextract_plugin_host& host_;
  CopyRow copy_row_;
  std::uint64_t sample_bytes_;
  std::int64_t component_offset_;
  std::uint64_t chunk_bytes_;
  tbb::enumerable_thread_specific<Workspace> spaces_;
  std::atomic<std::uint64_t> read_{0};
};

}  // namespace

ChunkCount read_box(const Store& store, const Array& array, const ArrayBox& box, const Conversion& conversion, void* to,
                    const isoextract_plugin_host& host) {
  if (!array.metadata.unsupported_feature.empty())
    throw ReadError("expected an array without " + array.metadata.unsupported_feature);
  return BoxReader(store, array, box, conversion, to, host).read();
}

bool visit_chunk_keys(const Array& array, const ArrayBox& box, std::uint64_t most,
                      const std::function<void(const std::string&)>& use) {
  const ChunkRange range = chunks_of(region_of(array, box), array.metadata.chunk);
  const std::uint64_t size = range.size();
  if (size > most) return false;
  for (std::uint64_t number = 0; number < size; ++number) {
    use(join(array.path, array.metadata.chunk_key(range.at(number))));
  }
  return true;
}

std::uint64_t count_chunks(const Array& array, const ArrayBox& box) {
  return chunks_of(region_of(array, box), array.metadata.inner_chunk()).size();
}

}  // namespace isoextract_zarr
