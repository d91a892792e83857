#include <algorithm>
#include <cmath>

#include "netcdf_parts.hpp"

namespace isoextract_netcdf {
namespace {

using isoextract_plugin::check_cancelled;

// The box of file samples that a selection needs, along the grid's axes.
struct SourceBox {
  std::array<std::uint64_t, 3> first{};
  std::array<std::uint64_t, 3> count{};

  [[nodiscard]] std::uint64_t samples() const { return count[0] * count[1] * count[2]; }
};

SourceBox source_box(const Variable& variable, const isoextract_volume_selection& selection) {
  SourceBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.first[axis] = selection.first[axis];
    box.count[axis] = selection.count[axis];
    const Resampling& resampling = variable.resampling[axis];
    if (resampling.lower.empty()) continue;
    box.first[axis] = resampling.lower[selection.first[axis]];
    box.count[axis] = resampling.lower[selection.first[axis] + selection.count[axis] - 1] + 2 - box.first[axis];
  }
  return box;
}

template <class T>
int get(const Variable& variable, const std::size_t* start, const std::size_t* count, T* to) {
  if constexpr (std::is_same_v<T, float>) return nc_get_vara_float(variable.group, variable.id, start, count, to);
  if constexpr (std::is_same_v<T, double>) return nc_get_vara_double(variable.group, variable.id, start, count, to);
  return nc_get_vara(variable.group, variable.id, start, count, to);  // bytes, as they are
}

// Chunks of a netCDF-4 variable. Reads cover whole chunk layers, so that each chunk is decoded once.
struct Chunks {
  std::vector<std::size_t> size;  // empty if samples are contiguous
  std::uint64_t bytes = 0;
};

Chunks find_chunks(const Variable& variable) {
  Chunks chunks;
  int storage = NC_CONTIGUOUS;
  std::vector<std::size_t> size(variable.shape.size());
  if (nc_inq_var_chunking(variable.group, variable.id, &storage, size.data()) != NC_NOERR || storage != NC_CHUNKED)
    return chunks;
  chunks.bytes = 8;
  for (std::size_t& length : size) {
    length = std::max<std::size_t>(length, 1);
    if (__builtin_mul_overflow(chunks.bytes, length, &chunks.bytes))
      throw ReadError("its chunks have more than 2^64 bytes");
  }
  chunks.size = std::move(size);
  return chunks;
}

void count_parts(const Variable& variable, const Chunks& chunks, const SourceBox& box, ReadFacts& facts) {
  if (chunks.size.empty()) return;
  facts.parts_read = 1;
  facts.parts = 1;
  for (std::size_t i = 0; i < variable.shape.size(); ++i)
    facts.parts *= (variable.shape[i] + chunks.size[i] - 1) / chunks.size[i];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t size = chunks.size[variable.dimension[axis]];
    facts.parts_read *= (box.first[axis] + box.count[axis] - 1) / size - box.first[axis] / size + 1;
  }
}

template <class T>
void read_box(const Variable& variable, const SourceBox& box, std::uint64_t volume, const Chunks& chunks,
              const isoextract_plugin_host& host, T* to) {
  std::vector<std::size_t> start(variable.shape.size());
  std::vector<std::size_t> count(variable.shape.size(), 1);
  for (std::size_t i = variable.volume_dimensions.size(); i-- > 0;) {
    const std::size_t dimension = variable.volume_dimensions[i];
    start[dimension] = volume % variable.shape[dimension];
    volume /= variable.shape[dimension];
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    start[variable.dimension[axis]] = box.first[axis];
    count[variable.dimension[axis]] = box.count[axis];
  }
  const std::size_t slow = variable.dimension[2];
  const std::uint64_t layer = box.count[0] * box.count[1];
  const std::uint64_t thickness = chunks.size.empty() ? 1 : chunks.size[slow];
  const std::uint64_t end = box.first[2] + box.count[2];
  for (std::uint64_t z = box.first[2]; z < end;) {
    check_cancelled(host);
    const std::uint64_t next = std::min(end, (z / thickness + 1) * thickness);
    start[slow] = z;
    count[slow] = next - z;
    T* const layers = to + (z - box.first[2]) * layer;
    const int status = get(variable, start.data(), count.data(), layers);
    if (status != NC_NOERR && status != NC_ERANGE) check(status, "netCDF cannot read its samples");
    z = next;
  }
}

// Replaces missing values by NaN.
template <class T>
void mark_missing(const Variable& variable, T* samples, std::uint64_t count) {
  std::vector<T> values;
  for (const double value : variable.missing.values) values.push_back(static_cast<T>(value));
  const auto least = static_cast<T>(variable.missing.least);
  const auto greatest = static_cast<T>(variable.missing.greatest);
  for (T* sample = samples; sample != samples + count; ++sample) {
    if (*sample < 0) *sample += static_cast<T>(variable.unsigned_range);
    const bool is_missing =
        *sample < least || *sample > greatest || std::ranges::any_of(values, [&](T value) { return *sample == value; });
    if (is_missing) *sample = std::numeric_limits<T>::quiet_NaN();
  }
}

// Resamples one axis of samples in memory, x fastest. `first`: file index of the first sample along that axis.
template <class T>
std::vector<T> resample(const std::vector<T>& from, std::array<std::uint64_t, 3>& dims, std::size_t axis,
                        std::uint64_t first, const Resampling& resampling, const isoextract_volume_selection& selection,
                        HostMemory& memory) {
  const std::uint64_t inner = axis == 0 ? 1 : axis == 1 ? dims[0] : dims[0] * dims[1];
  const std::uint64_t outer = axis == 2 ? 1 : axis == 1 ? dims[2] : dims[1] * dims[2];
  const std::uint64_t count = selection.count[axis];
  memory.take(inner * outer * count * sizeof(T));
  std::vector<T> to(inner * outer * count);
  for (std::uint64_t o = 0; o < outer; ++o) {
    for (std::uint64_t i = 0; i < count; ++i) {
      const double weight = resampling.weight[selection.first[axis] + i];
      const std::uint64_t lower = resampling.lower[selection.first[axis] + i] - first;
      const T* const a = from.data() + (o * dims[axis] + lower) * inner;
      const T* const b = a + inner;
      T* const result = to.data() + (o * count + i) * inner;
      for (std::uint64_t n = 0; n < inner; ++n) {
        result[n] = weight == 0   ? a[n]
                    : weight == 1 ? b[n]
                                  : static_cast<T>(static_cast<double>(a[n]) +
                                                   weight * (static_cast<double>(b[n]) - static_cast<double>(a[n])));
      }
    }
  }
  dims[axis] = count;
  return to;
}

template <class T>
void read_floats(const Variable& variable, const SourceBox& box, const Chunks& chunks,
                 const isoextract_volume_selection& selection, const isoextract_plugin_host& host) {
  T* const to = static_cast<T*>(selection.box);
  const bool is_resampled =
      std::ranges::any_of(variable.resampling, [](const Resampling& r) { return !r.lower.empty(); });
  if (!is_resampled) {
    read_box(variable, box, selection.volume, chunks, host, to);
    mark_missing(variable, to, box.samples());
    return;
  }
  HostMemory memory(host);
  memory.take(box.samples() * sizeof(T));
  std::vector<T> samples(box.samples());
  read_box(variable, box, selection.volume, chunks, host, samples.data());
  mark_missing(variable, samples.data(), box.samples());
  auto dims = box.count;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Resampling& resampling = variable.resampling[axis];
    if (!resampling.lower.empty())
      samples = resample(samples, dims, axis, box.first[axis], resampling, selection, memory);
  }
  std::ranges::copy(samples, to);
}

}  // namespace

ReadFacts read_variable(const Variable& variable, const Grid& grid, const isoextract_volume_selection& selection,
                        const isoextract_plugin_host& host) {
  if (variable.is_uneven) throw UnevenError(variable.problem);
  if (!variable.problem.empty()) throw ReadError(variable.problem);
  const SourceBox box = source_box(variable, selection);
  const Chunks chunks = find_chunks(variable);
  HostMemory chunk_memory(host);
  chunk_memory.take(chunks.bytes);
  switch (grid.sample_type) {
    case ISOEXTRACT_U8:
      read_box(variable, box, selection.volume, chunks, host, static_cast<std::uint8_t*>(selection.box));
      break;
    case ISOEXTRACT_I8:
      read_box(variable, box, selection.volume, chunks, host, static_cast<std::int8_t*>(selection.box));
      break;
    case ISOEXTRACT_F32: read_floats<float>(variable, box, chunks, selection, host); break;
    case ISOEXTRACT_F64: read_floats<double>(variable, box, chunks, selection, host); break;
    default: throw ReadError("expected a variable of numbers, found one of type " + grid.type_name);
  }
  ReadFacts facts;
  facts.note = variable.note;
  count_parts(variable, chunks, box, facts);
  return facts;
}

}  // namespace isoextract_netcdf
