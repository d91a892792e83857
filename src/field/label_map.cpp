#include "field/label_map.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include <tbb/enumerable_thread_specific.h>

#include "base/parallel.hpp"
#include "field/detail/sample_passes.hpp"
#include "field/label_value.hpp"
#include "field/statistics.hpp"

namespace isoextract::field {
namespace {

// The rule at the top of label_map.hpp.
constexpr std::uint64_t kLeastSamples = 512;
constexpr std::uint64_t kSamplesOfAValue = 8;
constexpr std::size_t kMostLabels = std::size_t{1} << 20U;
constexpr std::size_t kMaybeOrdered = 8;  // number of values that may differ by 1 without being a smooth field
constexpr double kLeastEqual = 0.5;
constexpr double kLeastEqualAlongAxis = 0.25;
constexpr double kMostUnitSteps = 0.75;

constexpr std::uint64_t kGuessSamples = std::uint64_t{1} << 17U;

// The voxels of one value.
struct LabelTally {
  std::uint64_t voxels = 0;
  glm::ivec3 min{std::numeric_limits<int>::max()};
  glm::ivec3 max{std::numeric_limits<int>::min()};
  std::array<std::uint64_t, 3> equal{};  // pairs of neighbors along i, j and k with this value at both ends

  void add(std::uint64_t count, const glm::ivec3& first, const glm::ivec3& last) {
    voxels += count;
    min = glm::min(min, first);
    max = glm::max(max, last);
  }
  void join(const LabelTally& other) {
    add(other.voxels, other.min, other.max);
    for (std::size_t axis = 0; axis < equal.size(); ++axis) equal[axis] += other.equal[axis];
  }
};

struct LabelTallies {
  std::unordered_map<std::int64_t, LabelTally> values;
  std::array<std::uint64_t, 3> different{};  // pairs of neighbors along i, j and k with different values
  std::uint64_t unit_steps = 0;              // of these, pairs whose values differ by exactly 1
  bool only_labels = true;

  void join(const LabelTallies& other) {
    for (const auto& [value, tally] : other.values) values[value].join(tally);
    for (std::size_t axis = 0; axis < different.size(); ++axis) different[axis] += other.different[axis];
    unit_steps += other.unit_steps;
    only_labels = only_labels && other.only_labels;
  }
  [[nodiscard]] std::uint64_t voxels() const {
    std::uint64_t sum = 0;
    for (const auto& entry : values) sum += entry.second.voxels;
    return sum;
  }
};

// Samples along one axis, and their neighbors along the other two; a null row where the box ends.
template <class T>
struct SampleRow {
  struct Beside {
    const T* samples = nullptr;
    std::size_t axis = 0;
  };
  const T* samples = nullptr;
  int length = 0;
  glm::ivec3 first{0};
  std::size_t axis = 0;
  std::array<Beside, 2> beside;
};

// A type in which adding 1 to a label is exact, except to 2^24 (f32) and 2^53 (f64), which stay what they are.
template <class T>
using LabelNumber =
    std::conditional_t<is_floating_sample<T>, std::conditional_t<std::is_same_v<T, double>, double, float>,
                       std::conditional_t<sizeof(T) <= 2, std::int32_t, std::int64_t>>;

// Counts the pairs of `value` with each of the `others`. A NaN is neither equal nor different.
template <class T>
void count_pairs(T value, std::span<const T> others, std::size_t axis, LabelTally& tally, LabelTallies& all) {
  using N = LabelNumber<T>;
  const N number = static_cast<N>(value);  // NOLINT(bugprone-signed-char-misuse): i8 samples are numbers
  std::uint32_t equal = 0;
  std::uint32_t different = 0;
  std::uint32_t steps = 0;
  for (const T sample : others) {
    const N other = static_cast<N>(sample);  // NOLINT(bugprone-signed-char-misuse): likewise
    equal += other == number ? 1U : 0U;
    const auto differs = static_cast<std::uint32_t>(other < number) | static_cast<std::uint32_t>(other > number);
    different += differs;
    // `differs` is for the largest labels of floating-point types, where adding 1 changes nothing.
    steps +=
        differs & (static_cast<std::uint32_t>(other == number + 1) | static_cast<std::uint32_t>(other == number - 1));
  }
  tally.equal[axis] += equal;
  all.different[axis] += different;
  all.unit_steps += steps;
}

// Adds a row run by run: runs of equal labels are long, so lookups in the table of values are rare.
template <class T>
void add_row(LabelTallies& all, const SampleRow<T>& row) {
  for (int begin = 0; begin < row.length;) {
    const T value = row.samples[begin];
    int end = begin + 1;
    while (end < row.length && row.samples[end] == value) ++end;
    const int first = std::exchange(begin, end);
    if constexpr (is_floating_sample<T>) {
      if (std::isnan(static_cast<double>(value))) continue;
    }
    if (!is_label(value)) {
      all.only_labels = false;
      return;
    }
    LabelTally& tally = all.values[static_cast<std::int64_t>(static_cast<LabelNumber<T>>(value))];
    const auto axis = static_cast<glm::length_t>(row.axis);
    glm::ivec3 low = row.first;
    glm::ivec3 high = row.first;
    low[axis] += first;
    high[axis] += end - 1;
    const auto count = static_cast<std::size_t>(end - first);
    tally.add(count, low, high);
    tally.equal[row.axis] += count - 1;
    if (end < row.length) count_pairs(value, std::span(row.samples + end, 1), row.axis, tally, all);
    for (const auto& beside : row.beside) {
      if (beside.samples != nullptr)
        count_pairs(value, std::span(beside.samples + first, count), beside.axis, tally, all);
    }
  }
}

// Returns the row of dense samples at index `first`, with neighbors up to `last`.
template <class T>
SampleRow<T> dense_row(const DenseSamples& dense, const glm::ivec3& first, const glm::ivec3& last) {
  const auto width = static_cast<std::size_t>(dense.dims.x);
  const std::size_t slice = width * static_cast<std::size_t>(dense.dims.y);
  const T* samples = static_cast<const T*>(dense.data) + static_cast<std::size_t>(first.x) +
                     width * static_cast<std::size_t>(first.y) + slice * static_cast<std::size_t>(first.z);
  SampleRow<T> row{samples, last.x - first.x + 1, first, 0, {}};
  if (first.y < last.y) row.beside[0] = {samples + width, 1};
  if (first.z < last.z) row.beside[1] = {samples + slice, 2};
  return row;
}

// Calls function(row) for the rows of a sparse block, along k.
template <class T, class Function>
void for_each_block_row(const SparseBlock& block, const Function& function) {
  constexpr int kSide = SparseBlock::kSize;
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const T* samples = static_cast<const T*>(block.values) + (i * kSide + j) * kSide;
      SampleRow<T> row{samples, kSide, block.origin + glm::ivec3(i, j, 0), 2, {}};
      if (j + 1 < kSide) row.beside[0] = {samples + kSide, 1};
      if (i + 1 < kSide) row.beside[1] = {samples + kSide * kSide, 0};
      function(row);
    }
  }
}

// Returns the background value of a sparse field; nullopt if the field is dense.
std::optional<std::int64_t> stated_background(const ScalarField& field) {
  const auto* sparse = std::get_if<SparseSamples>(&field.samples);
  return sparse != nullptr ? std::optional(static_cast<std::int64_t>(sparse->background)) : std::nullopt;
}

// Returns the value with the most voxels, the lowest such value if there are several; 0 if there are no voxels.
std::int64_t most_frequent_value(const LabelTallies& all) {
  std::int64_t found = 0;
  std::uint64_t most = 0;
  for (const auto& [value, tally] : all.values) {
    if (tally.voxels < most || (tally.voxels == most && value > found)) continue;
    found = value;
    most = tally.voxels;
  }
  return found;
}

struct LabelVerdict {
  std::optional<LabelMapKind> kind;
  double equal_share = 1;
  bool is_hopeless = false;  // so far from the rule that a part of the samples decides for all
};

// Applies the rule of label_map.hpp. `background` is set for sparse fields.
LabelVerdict judge_labels(const LabelTallies& all, std::optional<std::int64_t> background) {
  LabelVerdict verdict;
  const std::size_t values = all.values.size() + (background && !all.values.contains(*background) ? 1 : 0);
  const std::uint64_t voxels = all.voxels();
  // The small boxes of tally_some() have more labels per voxel than the whole field, hence the factor 2.
  verdict.is_hopeless = !all.only_labels || values > kMostLabels || values > 2 * voxels / kSamplesOfAValue;
  if (verdict.is_hopeless || values < 2 || values > voxels / kSamplesOfAValue) return verdict;
  const std::int64_t most_frequent = background.value_or(most_frequent_value(all));
  double all_equal = 0;
  double all_different = 0;
  bool flat_along_axes = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double equal = 0;
    for (const auto& [value, tally] : all.values) {
      if (value != most_frequent) equal += static_cast<double>(tally.equal[axis]);
    }
    const auto different = static_cast<double>(all.different[axis]);
    if (equal < kLeastEqualAlongAxis * (equal + different)) flat_along_axes = false;
    all_equal += equal;
    all_different += different;
  }
  if (all_equal + all_different > 0) verdict.equal_share = all_equal / (all_equal + all_different);
  if (values == 2) {
    verdict.kind = LabelMapKind::binary_mask;
    return verdict;
  }
  verdict.is_hopeless = verdict.equal_share < kLeastEqualAlongAxis;
  if (!flat_along_axes || verdict.equal_share < kLeastEqual) return verdict;
  if (values > kMaybeOrdered && static_cast<double>(all.unit_steps) > kMostUnitSteps * all_different) return verdict;
  verdict.kind = LabelMapKind::label_map;
  return verdict;
}

// Returns whether a field of this kind can hold labels, whatever its samples are. Returns false if only layers of the
// samples can be read.
bool may_hold_labels(const ScalarField& field) {
  if (field.kind != FieldKind::density || !field.scale.is_identity() || default_iso(field)) return false;
  if (const auto* dense = std::get_if<DenseSamples>(&field.samples)) {
    return dense->count() >= kLeastSamples && dense->layers == nullptr;
  }
  return !visit_sample_type(field.type(), []<class T>(std::type_identity<T>) { return is_floating_sample<T>; });
}

// Returns boxes of dense samples, at most kGuessSamples together: all samples if these are not more.
std::vector<IndexBox> boxes_to_guess_by(const DenseSamples& dense) {
  if (dense.count() <= kGuessSamples) return {{glm::ivec3(0), dense.dims - 1}};
  constexpr int kAlongAxis = 4;
  constexpr std::array kSides{32, 8, 8};
  static_assert(std::uint64_t{kSides[0]} * kSides[1] * kSides[2] * kAlongAxis * kAlongAxis * kAlongAxis ==
                kGuessSamples);
  std::array<std::vector<int>, 3> starts;
  glm::ivec3 sides(0);
  for (glm::length_t axis = 0; axis < 3; ++axis) {
    const auto n = static_cast<std::size_t>(axis);
    sides[axis] = std::min(kSides[n], dense.dims[axis]);
    const int boxes = std::min(kAlongAxis, (dense.dims[axis] + sides[axis] - 1) / sides[axis]);
    const std::int64_t space = dense.dims[axis] - sides[axis];
    for (int b = 0; b < boxes; ++b) starts[n].push_back(static_cast<int>(b * space / std::max(boxes - 1, 1)));
  }
  std::vector<IndexBox> boxes;
  for (const int z : starts[2]) {
    for (const int y : starts[1]) {
      for (const int x : starts[0]) boxes.push_back({{x, y, z}, glm::ivec3(x, y, z) + sides - 1});
    }
  }
  return boxes;
}

// Tallies the samples that guess_label_map() judges by.
LabelTallies tally_some(const ScalarField& field) {
  LabelTallies all;
  visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) {
    if (const auto* dense = std::get_if<DenseSamples>(&field.samples)) {
      for (const IndexBox& box : boxes_to_guess_by(*dense)) {
        for (int z = box.min.z; z <= box.max.z; ++z) {
          for (int y = box.min.y; y <= box.max.y && all.only_labels; ++y)
            add_row(all, dense_row<T>(*dense, {box.min.x, y, z}, box.max));
        }
      }
      return;
    }
    const std::vector<SparseBlock>& blocks = std::get<SparseSamples>(field.samples).blocks;
    const std::size_t count = std::min<std::size_t>(blocks.size(), kGuessSamples / kBlockSamples);
    for (std::size_t n = 0; n < count; ++n) {
      for_each_block_row<T>(blocks[n * blocks.size() / count], [&](const SampleRow<T>& row) { add_row(all, row); });
    }
  });
  return all;
}

// Tallies all stored samples; stops early if they cannot be labels.
template <class T>
LabelTallies tally_all(const ScalarField& field, std::uint64_t most_values, Progress* progress) {
  tbb::enumerable_thread_specific<LabelTallies> parts;
  std::atomic<bool> stopped{false};
  const auto add = [&](LabelTallies& part, const SampleRow<T>& row) {
    add_row(part, row);
    if (!part.only_labels || part.values.size() > most_values) stopped.store(true, std::memory_order_relaxed);
  };
  const auto begin_progress = [&](std::size_t count) {
    if (progress != nullptr) progress->begin("measuring labels", count);
  };
  if (const auto* dense = std::get_if<DenseSamples>(&field.samples)) {
    const auto rows = static_cast<std::size_t>(dense->dims.y) * static_cast<std::size_t>(dense->dims.z);
    begin_progress(rows);
    for_each_range(rows, 64, [&](std::size_t begin, std::size_t end) {
      LabelTallies& part = parts.local();
      for (std::size_t n = begin; n != end && !stopped.load(std::memory_order_relaxed); ++n) {
        const auto height = static_cast<std::size_t>(dense->dims.y);
        add(part,
            dense_row<T>(*dense, {0, static_cast<int>(n % height), static_cast<int>(n / height)}, dense->dims - 1));
      }
      if (progress != nullptr) progress->advance(end - begin);
    });
  } else {
    const std::vector<SparseBlock>& blocks = std::get<SparseSamples>(field.samples).blocks;
    begin_progress(blocks.size());
    for_each_range(blocks.size(), 16, [&](std::size_t begin, std::size_t end) {
      LabelTallies& part = parts.local();
      for (std::size_t b = begin; b != end && !stopped.load(std::memory_order_relaxed); ++b)
        for_each_block_row<T>(blocks[b], [&](const SampleRow<T>& row) { add(part, row); });
      if (progress != nullptr) progress->advance(end - begin);
    });
  }
  LabelTallies all;
  for (const LabelTallies& part : parts) all.join(part);
  return all;
}

// Adds the tiles of a sparse field. Returns the number of pairs within tiles of labels other than 0. Tiles of the
// background do not count, even if a field has some.
std::uint64_t add_tiles(const ScalarField& field, LabelTallies& all) {
  std::uint64_t pairs = 0;
  const auto* sparse = std::get_if<SparseSamples>(&field.samples);
  if (sparse == nullptr) return pairs;
  for (const SparseTile& tile : sparse->tiles) {
    if (tile.value == sparse->background) continue;
    LabelTally& tally = all.values[static_cast<std::int64_t>(tile.value)];
    tally.add(tile_voxels(tile), tile.origin, tile.origin + tile.size - 1);
    const auto side = static_cast<std::uint64_t>(tile.size);
    for (std::uint64_t& equal : tally.equal) equal += side * side * (side - 1);
    if (tile.value != 0) pairs += 3 * side * side * (side - 1);
  }
  return pairs;
}

}  // namespace

std::optional<LabelMap> measure_label_map(const ScalarField& field, Progress* progress) {
  if (!may_hold_labels(field)) return std::nullopt;
  const std::optional<std::int64_t> background = stated_background(field);
  if (judge_labels(tally_some(field), background).is_hopeless) return std::nullopt;
  LabelTallies all = visit_sample_type(
      field.type(), [&]<class T>(std::type_identity<T>) { return tally_all<T>(field, kMostLabels, progress); });
  const std::uint64_t pairs_in_tiles = add_tiles(field, all);
  const LabelVerdict verdict = judge_labels(all, background);
  if (!verdict.kind) return std::nullopt;
  LabelMap map{*verdict.kind, {}, {}, verdict.equal_share, 0};
  std::uint64_t voxels = 0;
  std::uint64_t pairs = 0;
  for (const auto& [value, tally] : all.values) {
    const std::int64_t label = field.label_ids ? (*field.label_ids)[static_cast<std::size_t>(value)] : value;
    const LabelFigures figures{label, tally.voxels, {tally.min, tally.max}};
    if (value == background) continue;
    if (label == 0) {
      if (!background) map.background = figures;
      continue;
    }
    map.labels.push_back(figures);
    voxels += tally.voxels;
    pairs += tally.equal[0] + tally.equal[1] + tally.equal[2];
  }
  if (map.labels.empty()) return std::nullopt;
  std::ranges::sort(map.labels, {}, &LabelFigures::label);
  // Seven of the eight samples of a block along an axis have their next neighbor in the same block.
  if (background) pairs = pairs_in_tiles + (pairs - pairs_in_tiles) * 8 / 7;
  map.faces = 6 * voxels - std::min(6 * voxels, 2 * pairs);
  return map;
}

std::optional<LabelMapKind> guess_label_map(const ScalarField& field) {
  if (!may_hold_labels(field)) return std::nullopt;
  return judge_labels(tally_some(field), stated_background(field)).kind;
}

}  // namespace isoextract::field
