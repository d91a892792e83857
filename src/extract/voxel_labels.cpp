// Finds the voxels of each label of a label map in one pass. A part is the voxels of one label in one chunk; the parts
// are sorted by label.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/byte_size.hpp"
#include "base/pages.hpp"
#include "base/parallel.hpp"
#include "extract/dense_input.hpp"
#include "extract/detail/label_bits.hpp"
#include "extract/detail/label_parts.hpp"
#include "extract/detail/label_samples.hpp"
#include "extract/detail/net_points.hpp"
#include "extract/detail/reserved_list.hpp"
#include "extract/detail/sparse_label_rows.hpp"
#include "extract/detail/voxel_input.hpp"
#include "extract/detail/voxel_mesh.hpp"
#include "extract/sparse_blocks.hpp"
#include "extract/voxels.hpp"
#include "field/sample_value.hpp"

namespace isoextract::extract {
namespace {

constexpr std::size_t kChunksATask = 256;

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
              : std::isinf(value) ? Hint("write labels in place of the infinite values, or NaN where there is no label")
              : is_large && is_double
                  ? Hint("renumber the labels: f64 represents all integers up to 2^53, above that only some")
              : is_large ? Hint("write the labels as integers")
                         : Hint());
}

// Returns whether a constant of a sparse field, rounded to the sample type, is a label; also true for NaN that counts
// as outside.
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
  return fail(
      ErrorCode::usage,
      fmt::format("{}: label {} is the background value of the sparse grid, so the region of this label is unbounded",
                  field.source, *around),
      {Remedy::set, Setting::labels, "with the other labels only"});
}

// Returns the note that so many bytes were in temporary files.
Note note_of_files(std::uint64_t bytes) {
  return {NoteId::voxels_in_files,
          fmt::format("memory is short for the {} of voxels and points of the net, so they are in "
                      "temporary files",
                      format_byte_size(bytes))};
}

// Releases the pages of each layer of chunks in a large mapped file as soon as all of its chunks are read.
template <class T>
class LayerReleases {
 public:
  LayerReleases(const DenseView<T>& view, const ChunkGrid& grid)
      : view_(view),
        chunks_(static_cast<std::size_t>(grid.size.x * grid.size.y)),
        left_(static_cast<std::size_t>(grid.size.z), chunks_) {}

  // Counts chunks begin to end - 1 as read. Safe to call from several threads.
  void finish(std::size_t begin, std::size_t end) {
    while (begin < end) {
      const std::size_t layer = begin / chunks_;
      const std::size_t next = std::min(end, (layer + 1) * chunks_);
      if (std::atomic_ref(left_[layer]).fetch_sub(next - begin) == next - begin) {
        const int first = kVoxelChunk.z * static_cast<int>(layer);
        view_.leave_slices(first, std::min(first + kVoxelChunk.z, view_.dims.z));
      }
      begin = next;
    }
  }

 private:
  const DenseView<T>& view_;
  std::size_t chunks_;             // in a layer
  std::vector<std::size_t> left_;  // chunks of each layer that are not read yet
};

}  // namespace

struct LabelVoxels::Found {
  Found(const Context& context, std::string text, const field::IndexBox& within, const OutputPlacement& placement,
        LabelIds table, bool nets)
      : what(std::move(text)),
        arrays(context, what),
        bits(arrays, nets),
        ids(std::move(table)),
        region(within),
        frame(placement) {}

  // A label, and the index of its first part; the parts up to the next label's first part belong to it.
  struct Entry {
    FoundLabel label;
    std::size_t first = 0;
  };

  std::string what;  // starts error messages
  NetMemory arrays;
  LabelBits bits;
  LabelIds ids;
  std::vector<std::int64_t> labels;  // ids, like those of FoundLabel
  Notes notes;
  std::optional<LabelFilter> filter;
  NanPolicy nan = NanPolicy::error;
  std::optional<NetPoints> net;  // for surface nets only
  glm::ivec3 base{0};
  field::IndexBox region;
  OutputPlacement frame;
  ExtractStats stats;
  std::optional<SparseLabelRows> sparse;                  // of sparse fields
  const std::vector<field::SparseTile>* tiles = nullptr;  // of the field in find(); used there only
  std::vector<Reservation> memory;
  std::vector<LabelPartList> tasks;
  std::vector<std::optional<NonLabelSample>> wrong;  // of each task: the first sample that is no label
  std::vector<std::uint64_t> nan_samples;            // of each task
  std::vector<const LabelPart*> parts;               // sorted by label, those of a label in chunk_order()
  std::vector<Entry> entries;                        // one for each label with parts, by rising id

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
      bits.place(tasks[p]);
      wrong[p] = chunk.wrong();
      nan_samples[p] = chunk.nan_samples();
      context.progress().advance(1);
    });
  }

  void find_dense(const field::DenseSamples& samples, const Context& context) {
    const ChunkGrid grid(region);
    stats.samples_classified = region.count();
    base = region.min;
    field::visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) {
      const DenseView<T> view = part_of(dense_view<T>(samples), region);
      LayerReleases<T> releases(view, grid);
      run(grid.count(), context, [&](ChunkLabels& chunk, std::size_t begin, std::size_t end, LabelPartList& list) {
        for (std::size_t n = begin; n < end && !chunk.wrong(); ++n)
          chunk.add(dense_rows(view, grid.origin(n)), grid.origin(n), list);
        releases.finish(begin, end);
      });
    });
    stats.nan_samples = std::reduce(nan_samples.begin(), nan_samples.end());
    // Releases the pages that LayerReleases kept: pages of small files, and pages that layers share. Nothing needs the
    // samples again.
    if (samples.file_backed) release_pages(samples.data, samples.count() * field::sample_size(samples.type));
  }

  [[nodiscard]] Result<void> find_sparse(const field::ScalarField& field, const field::SparseSamples& samples,
                                         const Context& context) {
    auto made = TRY(SparseLabelRows::make(field, samples, region, context, what));
    sparse.emplace(std::move(made));
    tiles = &samples.tiles;
    const SparseLabelRows::Chunks chunks = TRY(sparse->chunks(context));
    const std::vector<glm::ivec3>& origins = chunks.origins;
    stats.samples_classified = samples.blocks.size() * kBlockSize * kBlockSize * kBlockSize;
    field::visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) {
      run(origins.size(), context, [&](ChunkLabels& chunk, std::size_t begin, std::size_t end, LabelPartList& list) {
        SparseRows<T> rows = sparse->rows<T>();
        for (std::size_t n = begin; n < end && !chunk.wrong(); ++n) chunk.add(rows.read(origins[n]), origins[n], list);
      });
    });
    return {};
  }

  [[nodiscard]] std::span<const LabelPart* const> parts_of(const Entry& entry) const {
    return std::span(parts).subspan(entry.first, entry.label.chunks);
  }
  // Returns null if no sample has the label.
  [[nodiscard]] const Entry* entry_of(std::int64_t id) const {
    const auto found = std::ranges::lower_bound(entries, id, {}, [](const Entry& entry) { return entry.label.label; });
    return found != entries.end() && found->label.label == id ? &*found : nullptr;
  }

  // Sorts the parts by label, in chunk_order(), and sets `labels` to the chosen or the found labels.
  [[nodiscard]] Result<void> collect(const field::ScalarField& field, const LabelChoice& choice,
                                     const Context& context) {
    TRY(context.check());
    for (const std::optional<NonLabelSample>& sample : wrong) {
      if (!sample) continue;
      const glm::ivec3 at = base + sample->at;
      return refuse_sample(field, sample->value, fmt::format("at sample ({}, {}, {})", at.x, at.y, at.z));
    }
    std::uint64_t count = 0;
    for (const LabelPartList& task : tasks) {
      if (task.error()) return tl::unexpected(bits.explain(*task.error()));
      count += task.size();
    }
    auto held = TRY(context.reserve(count * 2 * sizeof(std::uintptr_t), what));
    memory.push_back(std::move(held));
    parts.reserve(count);
    for (const LabelPartList& task : tasks) {
      task.for_each([&](const LabelPart& part) { parts.push_back(&part); });
    }
    std::ranges::stable_sort(parts, {}, &LabelPart::label);
    make_entries();
    TRY(context.check());
    labels = choice.values;
    if (choice.all) {
      labels.clear();
      for (const Entry& entry : entries) labels.push_back(entry.label.label);
    }
    return {};
  }

  // Adds one entry for each label of the sorted parts.
  void make_entries() {
    std::size_t last = 0;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      if (p == 0 || parts[p]->label != parts[last]->label) {
        FoundLabel label;
        label.label = ids.id_of(parts[p]->label);
        entries.push_back({label, p});
        last = p;
      }
      ++entries.back().label.chunks;
    }
    for_each_index(entries.size(), [&](std::size_t e) { measure(entries[e]); });
    if (sparse) add_large_tiles();
    std::ranges::sort(entries, {}, [](const Entry& entry) { return entry.label.label; });
  }

  // Counts the voxels of the parts. Leaves out parts in large tiles: most chunks there are not listed;
  // add_large_tiles() counts these voxels.
  void measure(Entry& entry) const {
    for (const LabelPart* part : parts_of(entry)) {
      if (sparse && large_tile_at(part->origin) != nullptr) continue;
      const auto corner = [&](const std::array<std::uint8_t, 3>& at) {
        return base + part->origin + glm::ivec3(at[0], at[1], at[2]);
      };
      add(entry.label, part->voxels, {corner(part->least), corner(part->greatest)});
    }
  }

  static void add(FoundLabel& label, std::uint64_t voxels, const field::IndexBox& box) {
    label.bounds = label.voxels == 0
                       ? box
                       : field::IndexBox{glm::min(label.bounds.min, box.min), glm::max(label.bounds.max, box.max)};
    label.voxels += voxels;
  }

  // Returns the tile that contains the whole chunk, or null.
  [[nodiscard]] const field::SparseTile* large_tile_at(const glm::ivec3& origin) const {
    const std::int32_t place = sparse->lookup().place(origin);
    if (place >= field::SparseLookup::kBackground) return nullptr;
    const field::SparseTile& tile = (*tiles)[field::SparseLookup::tile_of(place)];
    return tile.size >= kVoxelChunk.x ? &tile : nullptr;
  }

  void add_large_tiles() {
    std::map<std::int64_t, Entry*> by_label;
    for (Entry& entry : entries) by_label[entry.label.label] = &entry;
    for (const field::SparseTile& tile : *tiles) {
      if (tile.size < kVoxelChunk.x || std::isnan(tile.value)) continue;
      const auto entry = by_label.find(static_cast<std::int64_t>(tile.value));
      const field::IndexBox within{glm::max(tile.origin, region.min),
                                   glm::min(tile.origin + tile.size - 1, region.max)};
      if (entry == by_label.end() || within.empty()) continue;
      add(entry->second->label, within.count(), within);
    }
  }

  // Returns the label of a chunk that lies within one large tile; nullopt if it has none.
  [[nodiscard]] std::optional<std::int64_t> label_of_tile(const glm::ivec3& origin) const {
    const std::int32_t place = sparse->lookup().place(origin);
    if (place >= field::SparseLookup::kBackground || !is_in(region, origin)) return std::nullopt;
    const double constant = sparse->lookup().constant_of(place);
    if (std::isnan(constant)) return std::nullopt;
    const auto label = static_cast<std::int64_t>(constant);
    return (*filter)(label) ? std::optional(label) : std::nullopt;
  }

  [[nodiscard]] Result<void> make_net(const ExtractOptions& options, const Context& context) {
    std::uint64_t count = 0;
    for (const LabelPartList& task : tasks) count += task.size();
    auto held = TRY(context.reserve(LabelChunks::bytes(count), what));
    std::vector<LabelChunk> chunks;
    chunks.reserve(count);
    for (const LabelPartList& task : tasks) {
      task.for_each([&](const LabelPart& part) { chunks.push_back({part.label, part.origin, part.bits, part.rows}); });
    }
    LabelChunks::Unlisted unlisted;
    if (sparse) unlisted = [this](const glm::ivec3& origin) { return label_of_tile(origin); };
    const field::IndexBox bounds{region.min - base, region.max - base};
    auto made = TRY(NetPoints::make(LabelChunks(std::move(chunks), std::move(unlisted), bounds, std::move(held)),
                                    options.relaxations, options.output_from_index.linear, arrays));
    net.emplace(std::move(made));
    for (const LabelShells& found : net->shells()) {
      const Entry* const entry = entry_of(ids.id_of(found.label));
      if (entry != nullptr) entries[static_cast<std::size_t>(entry - entries.data())].label.shells = found.shells;
    }
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
  const SparseBounds bounds = TRY(label_bounds(field, options));
  const field::IndexBox& region = bounds.region;
  const OutputPlacement frame = voxel_placement(field, options, bounds.stored, options.region ? region : bounds.stored);
  const bool nets = options.method == Method::surface_nets;
  auto found = std::make_shared<Found>(context, field.source + ": the voxels with labels", region, frame,
                                       LabelIds(field.label_ids), nets);
  found->filter.emplace(choice, nets, label_around(sparse), found->ids);
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
  if (const std::uint64_t bytes = found->arrays.most_in_files(); bytes > 0) {
    found->notes.push_back(note_of_files(bytes));
  }
  found->stats.classify = watch.elapsed();
  return LabelVoxels(std::move(found));
}

const std::vector<std::int64_t>& LabelVoxels::labels() const { return found_->labels; }

const Notes& LabelVoxels::notes() const { return found_->notes; }

const FoundLabel* LabelVoxels::find(std::int64_t label) const {
  const Found::Entry* entry = found_->entry_of(label);
  return entry != nullptr ? &entry->label : nullptr;
}

Result<Extraction> LabelVoxels::extract(const field::ScalarField& field, std::int64_t label,
                                        const ExtractOptions& options, const Context& context) const {
  const Found::Entry* entry = found_->entry_of(label);
  ExtractStats stats = found_->stats;
  stats.bricks_visited = entry != nullptr ? entry->label.chunks : 0;
  // All labels were found in one pass: only the first label's extraction reports the pass's time and samples.
  if (found_->labels.empty() || label != found_->labels.front()) {
    stats.classify = {};
    stats.samples_classified = 0;
    stats.nan_samples = 0;
  }
  if (entry == nullptr) return Extraction{{}, stats};
  const std::span<const LabelPart* const> parts = found_->parts_of(*entry);
  auto memory = TRY(context.reserve(VoxelChunks::bytes(parts.size()), found_->what));
  std::vector<VoxelChunk> chunks;
  chunks.reserve(parts.size());
  for (const LabelPart* part : parts) chunks.push_back({part->origin, part->bits});
  VoxelChunks::Unlisted unlisted;
  if (found_->sparse) {
    unlisted = [this, label](const glm::ivec3& origin) { return found_->label_of_tile(origin) == label; };
  }
  const VoxelChunks voxels(std::move(chunks), std::move(unlisted), found_, std::move(memory));
  auto extraction = TRY(mesh_voxels(field, voxels, found_->base, found_->frame, options, stats, context,
                                    found_->net ? &*found_->net : nullptr));
  // An access to a file brings 64 KiB around it into memory: to the bits, and to three arrays of the net.
  constexpr std::uint64_t kUsedPerChunk = 4 * (std::uint64_t{64} << 10U);
  found_->arrays.leave_after(kUsedPerChunk * parts.size());
  TRY(found_->arrays.check());
  return extraction;
}

}  // namespace isoextract::extract
