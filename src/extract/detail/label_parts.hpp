// The voxels of labels chunk by chunk: runs of equal samples become bits of their label.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "extract/dense_input.hpp"
#include "extract/detail/label_samples.hpp"
#include "extract/detail/reserved_list.hpp"
#include "extract/detail/voxel_chunks.hpp"
#include "extract/extractor.hpp"
#include "extract/sparse_blocks.hpp"
#include "extract/voxels.hpp"
#include "field/sample_value.hpp"
#include "field/scalar_field.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::extract {

inline constexpr std::uint32_t kChunkVoxels = 64 * 8 * 8;

// Returns whether a sample is NaN; it then has no label.
template <class T>
[[nodiscard]] bool is_no_number(T sample) {
  if constexpr (field::is_floating_sample<T>) {
    return std::isnan(static_cast<double>(sample));
  } else {
    return false;
  }
}

// The voxels of one label in a chunk. `label` is the stored value of the samples, even if the field has label_ids and
// the value is an index into them; LabelIds returns the id.
struct LabelPart {
  std::int64_t label = 0;
  glm::ivec3 origin{0};
  std::uint32_t voxels = 0;
  std::uint64_t rows = 0;                         // the rows that have voxels, as bits by chunk_row()
  std::array<std::uint8_t, 3> least{63, 63, 63};  // bounds of the voxels in the chunk
  std::array<std::uint8_t, 3> greatest{};
  const ChunkBits* bits = nullptr;  // not owned; full_chunk() if all voxels have the label

  [[nodiscard]] bool full() const { return voxels == kChunkVoxels; }

  // Counts voxels `begin` to `end` - 1 of a row.
  void add(std::size_t row, int begin, int end) {
    rows |= std::uint64_t{1} << row;
    voxels += static_cast<std::uint32_t>(end - begin);
    const std::array<int, 3> first{begin, static_cast<int>(row) & 7, static_cast<int>(row) >> 3};
    const std::array<int, 3> last{end - 1, first[1], first[2]};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      least[axis] = std::min(least[axis], static_cast<std::uint8_t>(first[axis]));
      greatest[axis] = std::max(greatest[axis], static_cast<std::uint8_t>(last[axis]));
    }
  }
};

// The parts of consecutive chunks, and their bits.
class LabelPartList {
 public:
  // Takes the arguments of a ReservedList.
  LabelPartList(const Context& context, const std::string& what) : parts_(context, what), bits_(context, what) {}

  // Appends a part with a copy of its bits. Returns false if memory ran out; error() then has the reason.
  bool add(LabelPart part, const ChunkBits& bits) {
    part.bits = part.full() ? &full_chunk() : bits_.add(bits);
    return part.bits != nullptr && parts_.add(part) != nullptr;
  }

  [[nodiscard]] std::size_t size() const { return parts_.size(); }
  [[nodiscard]] const std::optional<Error>& error() const { return parts_.error() ? parts_.error() : bits_.error(); }

  // Returns how many chunks of bits the list owns.
  [[nodiscard]] std::size_t own_bits() const { return bits_.size(); }
  // Moves its bits to other memory, which has space for own_bits() of them, and frees its own.
  void move_bits(std::span<ChunkBits> to) {
    std::size_t next = 0;
    parts_.for_each([&](LabelPart& part) {
      if (part.full()) return;
      to[next] = *part.bits;
      part.bits = &to[next++];
    });
    bits_.clear();
  }

  // Calls f(part) for the parts in their order. Parts keep their addresses.
  template <class F>
  void for_each(const F& f) const {
    parts_.for_each(f);
  }

 private:
  ReservedBlocks<LabelPart> parts_;
  ReservedBlocks<ChunkBits> bits_;
};

// The samples of a chunk as rows of 64, valid from `begin` to `end` - 1; rows beyond the region are null.
template <class T>
struct SampleRows {
  std::array<const T*, 64> rows{};
  int begin = 0;
  int end = 64;
};

// The ids of labels whose samples are indices into a table; without a table, a sample is its own id.
class LabelIds {
 public:
  explicit LabelIds(field::LabelIdTable table) : table_(std::move(table)) {}

  [[nodiscard]] std::int64_t id_of(std::int64_t sample) const {
    return table_ != nullptr ? (*table_)[static_cast<std::size_t>(sample)] : sample;
  }
  // Returns the sample value of an id: the id itself without a table; nullopt if the table lacks the id.
  [[nodiscard]] std::optional<std::int64_t> sample_of(std::int64_t id) const {
    if (table_ == nullptr || id == 0) return id;
    const auto found = std::lower_bound(table_->begin() + 1, table_->end(), id);
    return found != table_->end() && *found == id ? std::optional<std::int64_t>(found - table_->begin()) : std::nullopt;
  }

 private:
  field::LabelIdTable table_;
};

// Returns the background label of a sparse field; nullopt for NaN and for dense fields.
[[nodiscard]] inline std::optional<std::int64_t> label_around(const field::SparseSamples* sparse) {
  if (sparse == nullptr || std::isnan(sparse->background)) return std::nullopt;
  return static_cast<std::int64_t>(sparse->background);
}

// The labels to look for.
class LabelFilter {
 public:
  // `around`: the background label of a sparse field.
  LabelFilter(const LabelChoice& choice, bool net, std::optional<std::int64_t> around, const LabelIds& ids)
      : all_(choice.all || net), background_(ids.sample_of(choice.background)), around_(around) {
    if (choice.all) return;
    for (const std::int64_t id : choice.values) {
      if (const auto sample = ids.sample_of(id)) values_.push_back(*sample);
    }
    std::ranges::sort(values_);
  }

  [[nodiscard]] bool operator()(std::int64_t label) const {
    return (all_ && label != background_ && label != around_) || std::ranges::binary_search(values_, label);
  }

 private:
  std::vector<std::int64_t> values_;  // the chosen labels, sorted; they pass even if they are background_
  bool all_;                          // a net needs all labels, whichever are chosen
  std::optional<std::int64_t> background_;
  std::optional<std::int64_t> around_;
};

// Collects the labels of one chunk after the other, up to the first sample that is not a label.
class ChunkLabels {
 public:
  ChunkLabels(const LabelFilter& filter, NanPolicy nan) : filter_(filter), nan_(nan) {}

  [[nodiscard]] const std::optional<NonLabelSample>& wrong() const { return wrong_; }
  // Returns the number of NaN samples treated as outside.
  [[nodiscard]] std::uint64_t nan_samples() const { return nan_samples_; }

  template <class T>
  void add(const SampleRows<T>& samples, const glm::ivec3& origin, LabelPartList& found) {
    parts_.clear();
    for (std::size_t r = 0; r < samples.rows.size(); ++r) {
      const T* row = samples.rows[r];
      if (row == nullptr) continue;
      for (int x = samples.begin; x < samples.end;) {
        const T label = row[x];
        if (nan_ == NanPolicy::outside && is_no_number(label)) {
          ++nan_samples_;
          ++x;
          continue;
        }
        if (!is_label(label)) {
          const auto place = static_cast<int>(r);
          wrong_ = {static_cast<double>(label), origin + glm::ivec3(x, place & 7, place >> 3)};
          return;
        }
        int end = x + 1;
        while (end < samples.end && row[end] == label) ++end;
        if (Collected* one = part_of(static_cast<std::int64_t>(label))) one->add(r, x, end);
        x = end;
      }
    }
    for (Collected& one : parts_) {
      one.part.origin = origin;
      found.add(one.part, one.bits);
    }
  }

 private:
  struct Collected {
    LabelPart part;
    ChunkBits bits{};

    void add(std::size_t row, int begin, int end) {
      part.add(row, begin, end);
      bits[row] |= kAllBits >> (64 - (end - begin)) << begin;
    }
  };

  // Returns null for labels that are not looked for.
  Collected* part_of(std::int64_t label) {
    // Searches from the end, because the label is usually that of the previous run or row.
    for (std::size_t p = parts_.size(); p-- > 0;) {
      if (parts_[p].part.label == label) return &parts_[p];
    }
    if (!filter_(label)) return nullptr;
    parts_.emplace_back().part.label = label;
    return &parts_.back();
  }

  const LabelFilter& filter_;
  NanPolicy nan_;
  std::uint64_t nan_samples_ = 0;
  std::vector<Collected> parts_;
  std::optional<NonLabelSample> wrong_;
};

// Rows of sparse samples, assembled from blocks, tiles and the background.
template <class T>
class SparseRows {
 public:
  SparseRows(const field::SparseSamples& samples, const field::SparseLookup& lookup, const field::IndexBox& region)
      : samples_(samples), lookup_(lookup), region_(region) {}

  const SampleRows<T>& read(const glm::ivec3& origin) {
    for (int place = 0; place < 8; ++place) {
      const std::int32_t stored = lookup_.place(origin + glm::ivec3(kBlockSize * place, 0, 0));
      const T* block =
          stored >= 0 ? static_cast<const T*>(samples_.blocks[static_cast<std::size_t>(stored)].values) : nullptr;
      const T constant = block == nullptr ? field::to_sample<T>(lookup_.constant_of(stored)) : T{};
      for (int x = 0; x < kBlockSize; ++x) {
        for (int y = 0; y < kBlockSize; ++y) {
          for (int z = 0; z < kBlockSize; ++z) {
            values_[64 * chunk_row(y, z) + static_cast<std::size_t>(kBlockSize * place + x)] =
                block == nullptr ? constant : block[x << 6 | y << 3 | z];
          }
        }
      }
    }
    rows_.begin = std::clamp(region_.min.x - origin.x, 0, 64);
    rows_.end = std::clamp(region_.max.x - origin.x + 1, 0, 64);
    for (int z = 0; z < kBlockSize; ++z) {
      for (int y = 0; y < kBlockSize; ++y) {
        const glm::ivec3 p = origin + glm::ivec3(0, y, z);
        const bool holds = p.y >= region_.min.y && p.y <= region_.max.y && p.z >= region_.min.z && p.z <= region_.max.z;
        rows_.rows[chunk_row(y, z)] = holds ? values_.data() + 64 * chunk_row(y, z) : nullptr;
      }
    }
    return rows_;
  }

 private:
  const field::SparseSamples& samples_;
  const field::SparseLookup& lookup_;
  const field::IndexBox& region_;
  std::array<T, 64 * 64> values_;
  SampleRows<T> rows_;
};

// Returns rows of dense samples.
template <class T>
[[nodiscard]] SampleRows<T> dense_rows(const DenseView<T>& view, const glm::ivec3& origin) {
  SampleRows<T> rows;
  rows.end = std::min(64, view.dims.x - origin.x);
  for (int z = 0; z < std::min(kVoxelChunk.z, view.dims.z - origin.z); ++z) {
    for (int y = 0; y < std::min(kVoxelChunk.y, view.dims.y - origin.y); ++y) {
      rows.rows[chunk_row(y, z)] = view.row(origin.y + y, origin.z + z) + origin.x;
    }
  }
  return rows;
}

}  // namespace isoextract::extract
