// Finds the voxels of each label of a label map in one pass: in each chunk, runs of equal samples become bits of their
// label.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "extract/dense_input.hpp"
#include "extract/detail/label_samples.hpp"
#include "extract/detail/net_points.hpp"
#include "extract/detail/reserved_list.hpp"
#include "extract/detail/voxel_input.hpp"
#include "extract/detail/voxel_mesh.hpp"
#include "extract/sparse_blocks.hpp"
#include "extract/voxels.hpp"
#include "field/sample_value.hpp"

namespace isoextract::extract {
namespace {

constexpr std::size_t kChunksATask = 256;

// Returns whether a sample is NaN; it then has no label.
template <class T>
bool is_no_number(T sample) {
  if constexpr (field::is_floating_sample<T>) {
    return std::isnan(static_cast<double>(sample));
  } else {
    return false;
  }
}

// The voxels of one label in a chunk.
struct LabelPart {
  std::int64_t label = 0;
  glm::ivec3 origin{0};
  bool full = false;
  ChunkBits bits{};
};

// The samples of a chunk as rows of 64, valid from `begin` to `end` - 1; rows beyond the region are null.
template <class T>
struct SampleRows {
  std::array<const T*, 64> rows{};
  int begin = 0;
  int end = 64;
};

// The labels to look for.
class LabelFilter {
 public:
  // `around`: the background label of a sparse field.
  LabelFilter(const LabelChoice& choice, bool net, std::optional<std::int64_t> around)
      : values_(choice.all ? std::vector<std::int64_t>() : choice.values), all_(choice.all || net), around_(around) {}

  [[nodiscard]] bool operator()(std::int64_t label) const {
    return (all_ && label != 0 && label != around_) || std::ranges::find(values_, label) != values_.end();
  }

 private:
  std::vector<std::int64_t> values_;  // the chosen labels; if all_, labels to add even if 0 or background
  bool all_;                          // a net needs all labels, whichever are chosen
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
  void add(const SampleRows<T>& samples, const glm::ivec3& origin, ReservedList<LabelPart>& found) {
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
        if (ChunkBits* bits = bits_of(static_cast<std::int64_t>(label))) {
          (*bits)[r] |= kAllBits >> (64 - (end - x)) << x;
        }
        x = end;
      }
    }
    for (LabelPart& part : parts_) {
      part.origin = origin;
      part.full = part.bits == full_chunk();
      found.add(part);
    }
  }

 private:
  // Returns null for labels that are not looked for.
  ChunkBits* bits_of(std::int64_t label) {
    // Usually the label of the previous run or row.
    for (std::size_t p = parts_.size(); p-- > 0;) {
      if (parts_[p].label == label) return &parts_[p].bits;
    }
    if (!filter_(label)) return nullptr;
    parts_.emplace_back().label = label;
    return &parts_.back().bits;
  }

  const LabelFilter& filter_;
  NanPolicy nan_;
  std::uint64_t nan_samples_ = 0;
  std::vector<LabelPart> parts_;
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

template <class T>
SampleRows<T> dense_rows(const DenseView<T>& view, const glm::ivec3& origin) {
  SampleRows<T> rows;
  rows.end = std::min(64, view.dims.x - origin.x);
  for (int z = 0; z < std::min(kVoxelChunk.z, view.dims.z - origin.z); ++z) {
    for (int y = 0; y < std::min(kVoxelChunk.y, view.dims.y - origin.y); ++y) {
      rows.rows[chunk_row(y, z)] = view.row(origin.y + y, origin.z + z) + origin.x;
    }
  }
  return rows;
}

// Prints all digits of a whole number.
std::string text_of_sample(double value) {
  constexpr double kMost = 0x1p64;
  return std::abs(value) <= kMost && value == std::floor(value) ? fmt::format("{:.0f}", value)
                                                                : fmt::format("{}", value);
}

tl::unexpected<Error> refuse_sample(const field::ScalarField& field, double value, const std::string& place) {
  const double most =
      visit_sample_type(field.type(), []<class T>(std::type_identity<T>) { return largest_label<T>(); });
  // 64-bit integers are stored as f64, too.
  const bool is_double = field.type() == field::SampleType::f64;
  const bool is_large = std::abs(value) > most;
  return fail(ErrorCode::input,
              fmt::format("{}: expected a label map of whole numbers from -{} to {} (sample type {}), found {} {}",
                          field.source, text_of_sample(most), text_of_sample(most),
                          is_double ? "f64, or 64-bit integers" : field::sample_type_name(field.type()),
                          text_of_sample(value), place),
              std::isnan(value)
                  ? Hint(Remedy::set, Setting::nan_policy, "outside to treat NaN as outside, without a label")
              : is_large && is_double ? Hint("renumber the labels: f64 cannot represent all integers beyond 2^53")
              : is_large              ? Hint("write the labels as integers")
                                      : Hint());
}

// Returns whether a value is a label, or NaN that counts as outside. Constants of a sparse field are rounded to its
// sample type first.
bool has_place(const field::SparseSamples& sparse, double value, NanPolicy nan) {
  if (std::isnan(value)) return nan == NanPolicy::outside;
  return visit_sample_type(sparse.type,
                           [&]<class T>(std::type_identity<T>) { return is_label(field::to_sample<T>(value)); });
}

// Checks the background and the tile values of a sparse field.
Result<void> check_constants(const field::ScalarField& field, const field::SparseSamples& sparse, NanPolicy nan) {
  if (!has_place(sparse, sparse.background, nan)) return refuse_sample(field, sparse.background, "as the background");
  for (const field::SparseTile& tile : sparse.tiles) {
    if (has_place(sparse, tile.value, nan)) continue;
    const glm::ivec3& at = tile.origin;
    return refuse_sample(field, tile.value, fmt::format("in the tile at ({}, {}, {})", at.x, at.y, at.z));
  }
  return {};
}

// Returns the background label of a sparse field; nullopt for NaN and for dense fields.
std::optional<std::int64_t> label_around(const field::SparseSamples* sparse) {
  if (sparse == nullptr || std::isnan(sparse->background)) return std::nullopt;
  return static_cast<std::int64_t>(sparse->background);
}

Result<void> check_label_map(const field::ScalarField& field, const LabelChoice& choice, NanPolicy nan) {
  if (!field.scale.is_identity()) {
    return fail(ErrorCode::usage,
                fmt::format("{}: expected a label map with slope 1 and intercept 0, found slope {} and intercept {}",
                            field.source, field.scale.slope, field.scale.intercept));
  }
  const auto* sparse = std::get_if<field::SparseSamples>(&field.samples);
  if (sparse == nullptr) return {};
  if (auto whole = check_constants(field, *sparse, nan); !whole || choice.all) return whole;
  const auto around = label_around(sparse);
  if (!around || std::ranges::find(choice.values, *around) == choice.values.end()) return {};
  return fail(ErrorCode::usage,
              fmt::format("{}: label {} is the background value of the sparse grid, so its region is unbounded",
                          field.source, *around));
}

}  // namespace

struct LabelVoxels::Found {
  Found(std::string text, const field::IndexBox& within, const OutputPlacement& placement)
      : what(std::move(text)), region(within), frame(placement) {}

  std::string what;  // starts error messages
  std::vector<std::int64_t> labels;
  Notes notes;
  std::optional<LabelFilter> filter;
  NanPolicy nan = NanPolicy::error;
  std::optional<NetPoints> net;  // for surface nets only
  glm::ivec3 base{0};
  field::IndexBox region;
  OutputPlacement frame;
  ExtractStats stats;
  std::optional<field::SparseLookup> lookup;
  std::vector<Reservation> memory;
  std::vector<ReservedList<LabelPart>> tasks;
  std::vector<std::optional<NonLabelSample>> wrong;             // the first one of each task
  std::vector<std::uint64_t> nan_samples;                       // of each task
  std::map<std::int64_t, std::vector<const LabelPart*>> parts;  // in chunk_order()

  // Fills `tasks` in parallel: calls add(labels, begin, end, list) for portions of the `count` chunks.
  template <class Add>
  void run(std::size_t count, const Context& context, const Add& add) {
    stats.brick = "64x8x8 voxels";
    stats.bricks = count;
    stats.bricks_visited = count;
    const std::size_t portions = (count + kChunksATask - 1) / kChunksATask;
    tasks.clear();
    tasks.reserve(portions);
    for (std::size_t p = 0; p < portions; ++p) tasks.emplace_back(context, what);
    wrong.assign(portions, std::nullopt);
    nan_samples.assign(portions, 0);
    context.progress().begin("finding labels", portions);
    for_each_index(portions, [&](std::size_t p) {
      if (context.cancelled()) return;
      ChunkLabels chunk(*filter, nan);
      add(chunk, kChunksATask * p, std::min(kChunksATask * (p + 1), count), tasks[p]);
      wrong[p] = chunk.wrong();
      nan_samples[p] = chunk.nan_samples();
      context.progress().advance(1);
    });
  }

  void find_dense(const field::DenseSamples& samples, const Context& context) {
    const ChunkGrid grid(region);
    const glm::u64vec3 dims(region.dims());
    stats.samples_classified = dims.x * dims.y * dims.z;
    base = region.min;
    field::visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) {
      const DenseView<T> view = part_of(dense_view<T>(samples), region);
      run(grid.count(), context,
          [&](ChunkLabels& chunk, std::size_t begin, std::size_t end, ReservedList<LabelPart>& list) {
            for (std::size_t n = begin; n < end && !chunk.wrong(); ++n)
              chunk.add(dense_rows(view, grid.origin(n)), grid.origin(n), list);
          });
    });
    stats.nan_samples = std::reduce(nan_samples.begin(), nan_samples.end());
  }

  [[nodiscard]] Result<void> find_sparse(const field::ScalarField& field, const field::SparseSamples& samples,
                                         const Context& context) {
    std::vector<glm::ivec3> nodes = field::SparseLookup::node_origins(samples);
    auto held = TRY(context.reserve(nodes.size() * sizeof(field::SparseLookup::Node), what));
    memory.push_back(std::move(held));
    lookup.emplace(samples, std::move(nodes));
    Reservation list_memory;
    const auto origins = TRY(sparse_chunks(field, samples, region, false,
                                           std::vector<std::uint8_t>(samples.tiles.size(), 1), context, list_memory));
    stats.samples_classified = samples.blocks.size() * kBlockSize * kBlockSize * kBlockSize;
    field::visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) {
      run(origins.size(), context,
          [&](ChunkLabels& chunk, std::size_t begin, std::size_t end, ReservedList<LabelPart>& list) {
            SparseRows<T> rows(samples, *lookup, region);
            for (std::size_t n = begin; n < end && !chunk.wrong(); ++n)
              chunk.add(rows.read(origins[n]), origins[n], list);
          });
    });
    return {};
  }

  // Groups the parts by label, in chunk_order(), and sets `labels` to the chosen or the found labels.
  [[nodiscard]] Result<void> collect(const field::ScalarField& field, const LabelChoice& choice,
                                     const Context& context) {
    TRY(context.check());
    for (const std::optional<NonLabelSample>& sample : wrong) {
      if (!sample) continue;
      const glm::ivec3 at = base + sample->at;
      return refuse_sample(field, sample->value, fmt::format("at sample ({}, {}, {})", at.x, at.y, at.z));
    }
    std::uint64_t count = 0;
    for (const ReservedList<LabelPart>& task : tasks) {
      if (task.error()) return tl::unexpected(*task.error());
      count += task.values().size();
    }
    auto held = TRY(context.reserve(count * 2 * sizeof(std::uintptr_t), what));
    memory.push_back(std::move(held));
    for (const ReservedList<LabelPart>& task : tasks) {
      for (const LabelPart& part : task.values()) parts[part.label].push_back(&part);
    }
    labels = choice.values;
    if (choice.all) {
      labels.clear();
      for (const auto& [label, unused] : parts) labels.push_back(label);
    }
    return {};
  }

  // Returns the label of a chunk that lies within one large tile; nullopt if it has none.
  [[nodiscard]] std::optional<std::int64_t> label_of_tile(const glm::ivec3& origin) const {
    const std::int32_t place = lookup->place(origin);
    if (place >= field::SparseLookup::kBackground || !is_in(region, origin)) return std::nullopt;
    const double constant = lookup->constant_of(place);
    if (std::isnan(constant)) return std::nullopt;
    const auto label = static_cast<std::int64_t>(constant);
    return (*filter)(label) ? std::optional(label) : std::nullopt;
  }

  [[nodiscard]] Result<void> make_net(const ExtractOptions& options, const Context& context) {
    std::uint64_t count = 0;
    for (const ReservedList<LabelPart>& task : tasks) count += task.values().size();
    auto held = TRY(context.reserve(LabelChunks::bytes(count), what));
    std::vector<LabelChunk> chunks;
    chunks.reserve(count);
    for (const ReservedList<LabelPart>& task : tasks) {
      for (const LabelPart& part : task.values()) {
        chunks.push_back({part.label, part.origin, part.full ? &full_chunk() : &part.bits});
      }
    }
    LabelChunks::Unlisted unlisted;
    if (lookup) unlisted = [this](const glm::ivec3& origin) { return label_of_tile(origin); };
    const field::IndexBox bounds{region.min - base, region.max - base};
    auto made = TRY(NetPoints::make(LabelChunks(std::move(chunks), std::move(unlisted), bounds, std::move(held)),
                                    options.relaxations, options.output_from_index.linear, context, what));
    net.emplace(std::move(made));
    return {};
  }
};

Result<LabelVoxels> LabelVoxels::find(const field::ScalarField& field, const ExtractOptions& options,
                                      const LabelChoice& choice, const Context& context) {
  TRY(check_label_map(field, choice, options.nan));
  TRY(check_request(field, options));
  const Stopwatch watch;
  const auto* dense = std::get_if<field::DenseSamples>(&field.samples);
  const auto* sparse = std::get_if<field::SparseSamples>(&field.samples);
  field::IndexBox stored = dense != nullptr ? field::IndexBox{glm::ivec3(0), dense->dims - 1} : stored_box(*sparse);
  field::IndexBox region = stored;
  if (stored.empty()) {
    stored = region = {glm::ivec3(0), glm::ivec3(0)};
  } else if (dense != nullptr) {
    region = TRY(voxel_region(field, stored, options));
  } else {
    const auto reach = TRY(sparse_bounds(field, *sparse, options, false));
    region = reach.region;
  }
  const OutputPlacement frame = voxel_placement(field, options, stored, options.region ? region : stored);
  auto found = std::make_shared<Found>(field.source + ": the voxels with labels", region, frame);
  const bool nets = options.method == Method::surface_nets;
  found->filter.emplace(choice, nets, label_around(sparse));
  found->nan = options.nan;
  if (dense != nullptr) {
    found->find_dense(*dense, context);
  } else
    TRY(found->find_sparse(field, *sparse, context));
  TRY(found->collect(field, choice, context));
  if (nets) {
    TRY(found->make_net(options, context));
  }
  const bool floats =
      visit_sample_type(field.type(), []<class T>(std::type_identity<T>) { return field::is_floating_sample<T>; });
  if (floats) {
    found->notes.push_back(
        {NoteId::labels_assumed,
         fmt::format("{}: all of its samples{}, stored as {}, are whole numbers: the program uses them as labels",
                     field.source, found->stats.nan_samples > 0 ? " except NaN" : "",
                     field::sample_type_name(field.type()))});
  }
  found->stats.classify = watch.elapsed();
  return LabelVoxels(std::move(found));
}

const std::vector<std::int64_t>& LabelVoxels::labels() const { return found_->labels; }

const Notes& LabelVoxels::notes() const { return found_->notes; }

Result<Extraction> LabelVoxels::extract(const field::ScalarField& field, std::int64_t label,
                                        const ExtractOptions& options, const Context& context) const {
  const auto entry = found_->parts.find(label);
  if (entry == found_->parts.end()) return Extraction{{}, found_->stats};
  auto memory = TRY(context.reserve(VoxelChunks::bytes(entry->second.size()), found_->what));
  std::vector<VoxelChunk> chunks;
  chunks.reserve(entry->second.size());
  for (const LabelPart* part : entry->second) {
    chunks.push_back({part->origin, part->full ? &full_chunk() : &part->bits});
  }
  VoxelChunks::Unlisted unlisted;
  if (found_->lookup) {
    unlisted = [this, label](const glm::ivec3& origin) { return found_->label_of_tile(origin) == label; };
  }
  const VoxelChunks voxels(std::move(chunks), std::move(unlisted), found_, std::move(memory));
  ExtractStats stats = found_->stats;
  if (label != found_->labels.front())
    stats.classify = {};  // all labels were found in one pass: only the first
                          // reports its time
  return mesh_voxels(field, voxels, found_->base, found_->frame, options, stats, context,
                     found_->net ? &*found_->net : nullptr);
}

}  // namespace isoextract::extract
