// Not by Interpolant: that answers NaN beside every sample that is not finite, whether it counts or not, its weighted
// sum can leave the range of the samples, and its gradients would be for nothing.
#include "field/resample.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "base/byte_size.hpp"
#include "base/checked.hpp"
#include "base/reserved_buffer.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::field {
namespace {

template <class T>
using Resampled =
    std::conditional_t<std::is_same_v<T, double> || std::is_same_v<T, std::uint32_t> || std::is_same_v<T, std::int32_t>,
                       double, float>;

// Where a new sample is among the old ones of an axis: (1 - t) of the one below, t of the next.
struct Between {
  int below;
  double t;  // in [0, 1), and exactly 0 at old samples
};

Between place_of(int i, int old_count, int new_count) {
  const std::int64_t steps = new_count - 1;
  const std::int64_t scaled = std::int64_t{i} * (old_count - 1);
  return {static_cast<int>(scaled / steps), static_cast<double>(scaled % steps) / static_cast<double>(steps)};
}

// NaN passes the clamp. Without the clamp, rounding could leave the range of a and b, and the range of double.
double blend(double a, double b, double t) {
  return t == 0 ? a : std::clamp((1 - t) * a + t * b, std::min(a, b), std::max(a, b));
}

// Rows of a field's samples along x. y and z count from the low corner of the box.
template <class T>
class SourceRows {
 public:
  SourceRows(const Samples& samples, const IndexBox& box)
      : dense_(std::get_if<DenseSamples>(&samples)), sparse_(std::get_if<SparseSamples>(&samples)), box_(box) {
    if (sparse_ != nullptr) lookup_.emplace(*sparse_);
  }

  void read(int y, int z, double* row) const {
    if (dense_ != nullptr) {
      const glm::i64vec3 dims(dense_->dims);
      const T* from = static_cast<const T*>(dense_->data) + dims.x * (y + dims.y * z);
      std::transform(from, from + dims.x, row, [](T value) { return static_cast<double>(value); });
      return;
    }
    const glm::ivec3 first = box_.min + glm::ivec3(0, y, z);
    for (int x = first.x; x <= box_.max.x;) {
      const glm::ivec3 origin = block_origin({x, first.y, first.z});
      const int end = std::min(origin.x + SparseBlock::kSize, box_.max.x + 1);
      const std::int32_t block = lookup_->block(origin);
      if (block < 0) {
        row = std::fill_n(row, end - x, lookup_->constant(origin));
        x = end;
        continue;
      }
      const auto* values = static_cast<const T*>(sparse_->blocks[block].values);
      for (; x < end; ++x) *row++ = static_cast<double>(values[block_offset({x, first.y, first.z})]);
    }
  }

 private:
  const DenseSamples* dense_;
  const SparseSamples* sparse_;
  std::optional<SparseLookup> lookup_;
  IndexBox box_;
};

// Old rows, blended along z, of one new plane. Keeps the last two: a walk along y needs each row several times.
template <class T>
class PlaneRows {
 public:
  PlaneRows(const SourceRows<T>& source, int width, const Between& z)
      : source_(source), z_(z), above_(static_cast<std::size_t>(width)) {
    for (Row& row : rows_) row.values.resize(above_.size());
  }

  const std::vector<double>& operator()(int y) {
    Row& row = rows_[y & 1];
    if (row.y == y) return row.values;
    row.y = y;
    source_.read(y, z_.below, row.values.data());
    if (z_.t > 0) {
      source_.read(y, z_.below + 1, above_.data());
      for (std::size_t i = 0; i < above_.size(); ++i) row.values[i] = blend(row.values[i], above_[i], z_.t);
    }
    return row.values;
  }

 private:
  struct Row {
    int y = -1;
    std::vector<double> values;
  };

  const SourceRows<T>& source_;
  Between z_;
  std::array<Row, 2> rows_;
  std::vector<double> above_;
};

template <class T>
void fill(const SourceRows<T>& source, const glm::ivec3& old_dims, const glm::ivec3& dims, Resampled<T>* values,
          const Context& context) {
  constexpr int kRows = 64;  // of a new plane, in one go
  std::vector<Between> along_x;
  along_x.reserve(static_cast<std::size_t>(dims.x));
  for (int i = 0; i < dims.x; ++i) along_x.push_back(place_of(i, old_dims.x, dims.x));
  const std::int64_t bands = (std::int64_t{dims.y} + kRows - 1) / kRows;
  context.progress().begin("resampling", static_cast<std::uint64_t>(bands * dims.z));
  tbb::parallel_for(std::int64_t{0}, bands * dims.z, [&](std::int64_t part) {
    const auto k = static_cast<int>(part / bands);
    const int first = static_cast<int>(part % bands) * kRows;
    const int end = first + std::min(kRows, dims.y - first);
    PlaneRows<T> plane(source, old_dims.x, place_of(k, old_dims.z, dims.z));
    // One more, which counts for nothing beside the last sample.
    std::vector<double> row(static_cast<std::size_t>(old_dims.x) + 1);
    Resampled<T>* out = values + static_cast<std::int64_t>(dims.x) * (first + static_cast<std::int64_t>(dims.y) * k);
    for (int j = first; j < end; ++j) {
      const Between y = place_of(j, old_dims.y, dims.y);
      std::ranges::copy(plane(y.below), row.begin());
      if (y.t > 0) {
        const std::vector<double>& above = plane(y.below + 1);
        for (std::size_t i = 0; i < above.size(); ++i) row[i] = blend(row[i], above[i], y.t);
      }
      for (const Between& x : along_x) {
        const double* at = row.data() + x.below;
        *out++ = static_cast<Resampled<T>>(blend(at[0], at[1], x.t));
      }
    }
    context.progress().advance(1);
  });
}

// Beyond this box, and on its faces, all is background.
template <class T>
IndexBox box_in_background(const SparseSamples& sparse) {
  IndexBox box = sparse.active_box;
  const auto add = [&](const glm::ivec3& low, const glm::ivec3& high) {
    box = box.empty() ? IndexBox{low, high} : IndexBox{glm::min(box.min, low), glm::max(box.max, high)};
  };
  for (const SparseBlock& block : sparse.blocks) {
    const glm::ivec3 last = block.origin + (SparseBlock::kSize - 1);
    if (glm::min(box.min, block.origin) == box.min && glm::max(box.max, last) == box.max) continue;
    for (int v = 0; v < SparseBlock::kSize * SparseBlock::kSize * SparseBlock::kSize; ++v) {
      if (static_cast<double>(static_cast<const T*>(block.values)[v]) == sparse.background) continue;
      const glm::ivec3 p = block.origin + glm::ivec3(v >> 6, v >> 3 & 7, v & 7);
      add(p, p);
    }
  }
  for (const SparseTile& tile : sparse.tiles) add(tile.origin, tile.origin + (tile.size - 1));
  if (box.empty()) box = {glm::ivec3(0), glm::ivec3(0)};
  return {box.min - 1, box.max + 1};
}

std::string dims_text(const glm::i64vec3& dims) { return fmt::format("{} x {} x {}", dims.x, dims.y, dims.z); }

template <class T>
Result<ScalarField> resampled(const ScalarField& field, const glm::ivec3& resolution, const Context& context) {
  const auto* sparse = std::get_if<SparseSamples>(&field.samples);
  const IndexBox box = sparse != nullptr ? box_in_background<T>(*sparse) : field.extents();
  const glm::ivec3 old_dims(box.dims());
  ScalarField result = field;
  result.notes.clear();
  if (sparse == nullptr && old_dims == resolution) return result;

  using Value = Resampled<T>;
  const glm::u64vec3 counts(resolution);
  const std::uint64_t count = checked_product(counts.x, counts.y, counts.z).value_or(~std::uint64_t{0});
  const std::string size =
      fmt::format("{} samples of {}", dims_text(resolution), sample_type_name(sample_type_of<Value>()));
  auto values = make_reserved_buffer<Value>(count, context, fmt::format("{}: {}", field.source, size));
  if (!values) return tl::unexpected(values.error());
  if (sparse != nullptr) {
    result.notes.push_back(
        fmt::format("{}: its sparse samples become {} ({}), which cover the voxels ({}, {}, {}) .. ({}, {}, {})",
                    field.source, size, format_byte_size(count * sizeof(Value)), box.min.x, box.min.y, box.min.z,
                    box.max.x, box.max.y, box.max.z));
  }
  DenseSamples samples;
  samples.type = sample_type_of<Value>();
  samples.dims = resolution;
  fill(SourceRows<T>(field.samples, box), old_dims, resolution, (*values)->values.data(), context);
  samples.data = (*values)->values.data();
  samples.owner = std::move(*values);

  Affine old_from_new = scaling(glm::dvec3(old_dims - 1) / glm::dvec3(resolution - 1));
  old_from_new.offset = box.min;
  result.index_to_world = field.index_to_world.after(old_from_new);
  result.index_to_file = field.index_to_file.after(old_from_new);
  result.samples = std::move(samples);
  return result;
}

}  // namespace

Result<ScalarField> resample(const ScalarField& field, const glm::ivec3& resolution, const Context& context) {
  if (glm::any(glm::lessThan(resolution, glm::ivec3(2)))) {
    return fail(ErrorKind::usage,
                fmt::format("a resolution needs at least 2 samples along each axis, found {}", dims_text(resolution)));
  }
  if (const auto* dense = std::get_if<DenseSamples>(&field.samples);
      dense != nullptr && glm::any(glm::lessThan(dense->dims, glm::ivec3(2)))) {
    return fail(ErrorKind::input,
                fmt::format("{}: another resolution needs at least 2 samples along each axis, found {}", field.source,
                            dims_text(dense->dims)));
  }
  return visit_sample_type(field.type(),
                           [&]<class T>(std::type_identity<T>) { return resampled<T>(field, resolution, context); });
}

}  // namespace isoextract::field
