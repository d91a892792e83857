#include "extract/detail/dense_extractor.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "base/stopwatch.hpp"
#include "extract/dense_input.hpp"
#include "extract/detail/brick_flags.hpp"
#include "extract/detail/cell_rows.hpp"
#include "extract/detail/cell_streams.hpp"
#include "extract/detail/row_ends.hpp"
#include "extract/detail/row_table.hpp"
#include "extract/detail/sample_chooser.hpp"
#include "extract/detail/sample_gradient.hpp"
#include "extract/detail/slab_shares.hpp"
#include "extract/detail/slab_views.hpp"
#include "extract/detail/slab_workers.hpp"
#include "extract/detail/vertex_batch.hpp"
#include "extract/row_bits.hpp"
#include "extract/surface_run.hpp"

namespace isoextract::extract {
namespace {

template <class T>
class DenseExtraction final {
 public:
  DenseExtraction(const field::ScalarField& field, const field::DenseSamples& samples, const field::IndexBox& region,
                  std::optional<DenseMasks> masks, const ExtractOptions& options, const Context& context,
                  Ranks* ranks = nullptr)
      : field_(field),
        options_(options),
        context_(context),
        ranks_(ranks),
        rule_{field.kind, options.iso},
        layers_(samples.layers),
        whole_(dense_view<T>(samples)),
        view_(part_of(whole_, region)),
        region_(region),
        table_(case_table(options.method)),
        directions_(static_cast<int>(table_.directions.size())),
        placement_(output_placement(field, options, {glm::ivec3(0), whole_.dims - 1}, region)),
        masks_(std::move(masks)),
        own_(own_slabs(BrickFlags::count_slabs(view_.dims), ranks)),
        // Cells of the last own slab use vertices of the next rank's first slab. Counting that slab gives their
        // numbers.
        counted_{own_.begin,
                 own_.count() == 0 ? own_.end : std::min(own_.end + 1, BrickFlags::count_slabs(view_.dims))},
        bricks_(view_.dims, counted_),
        rows_(view_.dims.y, directions_, slices_below(own_.begin), slices_below(counted_.end)),
        row_ends_(view_.dims, slices_below(own_.begin), slices_below(counted_.end), options.cap && !masks_) {}

  [[nodiscard]] const OutputPlacement& placement() const { return placement_; }

  Result<bool> classify(ExtractStats& stats) {
    stats.brick = fmt::format("64x{0}x{0} cells", kBrickRows);
    stats.bricks = bricks_.count();
    if (!masks_) return find_threshold(stats);
    const auto threshold = TRY(classify_dense(field_, view_, region_.min, options_, *masks_, stats, context_));
    sides_ = masks_->boundary_sides();
    has_holes_ = stats.nan_samples != 0 && options_.nan == NanPolicy::hole;
    return threshold.has_value();
  }

  Result<MeshSizes> count(ExtractStats& stats) {
    const Stopwatch watch;
    rows_memory_ =
        TRY(context_.reserve(bricks_.bytes() + rows_.bytes() + row_ends_.bytes(),
                             fmt::format("{}: the table of its {} rows of samples", field_.source, rows_.rows())));
    bricks_.allocate();
    drawings_.emplace(row_drawings(table_, placement_.mirrored(), has_holes_));
    rows_.allocate();
    row_ends_.allocate();
    if (masks_) {
      stats.hole_cells = count_rows();
    } else {
      TRY(count_slabs(stats));
    }
    const MeshSizes sizes = TRY(place_rows(stats));
    stats.count = watch.elapsed();
    return sizes;
  }

  Result<void> emit(mesh::Mesh& mesh) {
    if (masks_) {
      for_each_brick_row("extracting", [&](int bj, int bk) { emit_brick_row(mesh, {}, slab_in_memory(bk), bj); });
    } else {
      TRY(for_each_slab("extracting", own_, {}, [&](const Slab& slab, mesh::Mesh& /*part*/) -> Result<void> {
        if (!is_as_counted(slab)) return {};
        for (int bj = 0; bj < bricks_.rows_y(); ++bj) emit_brick_row(mesh, {}, slab, bj);
        return {};
      }));
    }
    return check_samples();
  }

  // A part of the mesh is a slab: the rows of bricks of one index along z, whose vertices have consecutive numbers.
  Result<void> deliver(mesh::MeshSink& sink, const mesh::PartPass& pass) {
    PartRoom room{{}, options_in(pass, options_), pass.in_order ? 1 : usable_threads()};
    for (int bk = own_.begin; bk < own_.end; ++bk) {
      const MeshSizes sizes = sizes_in(pass, slab_sizes(bk));
      room.sizes = {std::max(room.sizes.vertices, sizes.vertices), std::max(room.sizes.triangles, sizes.triangles)};
    }
    TRY(for_each_slab("extracting", own_, room, [&](const Slab& slab, mesh::Mesh& part) -> Result<void> {
      const MeshSizes first = rows_.numbers_at(slices_below(slab.bk));
      const MeshSizes sizes = sizes_in(pass, slab_sizes(slab.bk));
      const bool is_empty = sizes.vertices == 0 && sizes.triangles == 0;
      if (is_empty && !options_.cap) return {};  // the cap of a slab without a surface compares its samples again
      if (!is_as_counted(slab) || is_empty) return check_samples();
      const auto emit = [&](int bj) { emit_brick_row(part, first, slab, bj); };
      if (pass.in_order) for_each_index(bricks_.rows_y(), emit);
      for (int bj = 0; bj < bricks_.rows_y() && !pass.in_order; ++bj) emit(bj);
      return deliver_part(sink, pass, part, first, sizes);
    }));
    return check_samples();
  }

  [[nodiscard]] bool uses_near_vertices() const { return true; }
  [[nodiscard]] std::optional<RankSlices> rank_slices() const {
    if (ranks_ == nullptr) return std::nullopt;
    return slices_of_rank(*ranks_, slices_below(own_.begin), slices_below(own_.end), region_.min.z, rows_);
  }
  [[nodiscard]] std::optional<field::IndexBox> cap_box() const { return region_; }
  [[nodiscard]] BoundarySides boundary_sides() const { return sides_; }
  [[nodiscard]] bool draws_at_boundary() const {
    return extract::draws_at_boundary(
        region_, [this](const glm::ivec3& p) { return inside(p); },
        [this](const glm::ivec3& p) { return std::isnan(value(p)); });
  }
  [[nodiscard]] bool has_holes() const { return has_holes_; }
  [[nodiscard]] bool inside(const glm::ivec3& p) const {
    if (masks_) return masks_->inside(p - region_.min);
    return row_ends_.knows(p - region_.min) ? row_ends_.inside(p - region_.min) : rule_(value(p));
  }
  [[nodiscard]] double value(const glm::ivec3& p) const {
    return field_.scale(static_cast<double>(whole_.row(p.y, p.z)[p.x]));
  }

  // Returns the number of one vertex by counting; slow, for the few vertices that are not visited in order.
  [[nodiscard]] std::uint32_t edge_vertex(const glm::ivec3& sample, int direction) const {
    const glm::ivec3 p = sample - region_.min;
    const glm::ivec3 upper = p + direction_step(direction & ~1);
    std::uint32_t number = rows_.vertices(rows_.index(p.y, p.z))[table_.index_of(direction)];
    for (int w = 0; w <= p.x / 64; ++w) {
      const std::uint64_t here = mask_word(upper.y, upper.z, w);
      const std::uint64_t ends = (direction & 1) != 0 ? here >> 1U | mask_word(upper.y, upper.z, w + 1) << 63U : here;
      number += static_cast<std::uint32_t>(std::popcount((mask_word(p.y, p.z, w) ^ ends) & bits_below(w, p.x)));
    }
    return number;
  }

 private:
  // A slab at work, with the masks of its samples and of the slice behind it.
  struct Slab {
    int bk;
    const DenseMasks& masks;
    DenseView<T> whole;  // view of all samples, in which those that the work needs can be read
    SliceSides sides;    // of its samples alone; unknown if the extraction has masks of all samples
  };

  // The meshes in which threads make parts: the sizes of the largest part, and the largest number of threads.
  struct PartRoom {
    MeshSizes sizes;
    ExtractOptions options;
    int threads = usable_threads();
  };

  // Runs work(slab, part) for every slab of a range, in parallel. `part` is memory of the thread: a mesh with room for
  // `room`. Releases the pages of each slab. Fails as `work` does, and as run_slabs().
  template <class Work>
  Result<void> for_each_slab(const char* stage, const SlabRange& slabs, const PartRoom& room, const Work& work) {
    struct Worker {
      SlabViews<T> views;
      std::optional<DenseMasks> masks = {};
      Reservation memory = {};
      mesh::Mesh part = {};
    };
    const SlabReach reach{region_, options_.smooth_normals ? SlabReach::kOfGradients : 0};
    const int end = std::min(slices_below(slabs.end) + 1, view_.dims.z);
    PageRequests requests = masks_ ? PageRequests() : view_.page_requests(slices_below(slabs.begin), end);
    bool is_first = true;
    const auto make = [&]() -> Result<Worker> {
      if (layers_ != nullptr && !std::exchange(is_first, false)) TRY(check_room_for_window(field_, whole_, reach));
      Worker worker{TRY(SlabViews<T>::open(whole_, layers_, reach))};
      if (!masks_) worker.masks = TRY(make_masks(field_, view_.dims, std::min(kSlabSlices, view_.dims.z), context_));
      worker.memory = TRY(reserve_mesh(field_, room.sizes, room.options, context_));
      allocate_mesh(worker.part, room.sizes, {}, room.options);
      return worker;
    };
    return run_slabs(slabs.count(), room.threads, stage, context_, make,
                     [&](int number, Worker& worker) -> Result<void> {
                       const int bk = slabs.begin + number;
                       Slab slab{bk, worker.masks ? *worker.masks : *masks_, TRY(worker.views.show(bk)), {}};
                       const DenseView<T> view = part_of(slab.whole, region_);
                       if (worker.masks) slab.sides = mark_slab(view, threshold_, bk, *worker.masks, requests);
                       TRY(work(slab, worker.part));
                       leave(bk);
                       return {};
                     });
  }

  [[nodiscard]] Slab slab_in_memory(int bk) const { return {bk, *masks_, whole_, {}}; }
  [[nodiscard]] SampleChooser<T> chooser_in(const Slab& slab) const {
    return {table_, rule_, field_.scale, has_holes_, part_of(slab.whole, region_)};
  }

  // Replaces classify() if there is no memory for masks of all samples. Returns false if no sample can be inside;
  // otherwise count() compares the samples.
  Result<bool> find_threshold(ExtractStats& stats) {
    const auto threshold = find_inside_threshold<T>(rule_, field_.scale);
    threshold_ = threshold.value_or(InsideThreshold<T>{});
    if (threshold || !field::is_floating_sample<T> || options_.nan != NanPolicy::error) return threshold.has_value();
    std::atomic<std::uint64_t> nan{0};
    TRY(for_each_slab("classifying samples", own_, {}, [&](const Slab& slab, mesh::Mesh& /*part*/) -> Result<void> {
      nan += slab.sides.nan;
      return {};
    }));
    TRY(check_nan(nan, stats));
    return false;
  }

  Result<void> check_nan(std::uint64_t nan, ExtractStats& stats) const {
    stats.nan_samples = nan;
    if (nan == 0 || options_.nan != NanPolicy::error) return {};
    return nan_error(field_, nan, TRY(first_nan(whole_, layers_, region_)));
  }

  // Compares the samples and counts, slab by slab.
  Result<void> count_slabs(ExtractStats& stats) {
    std::mutex mutex;
    slab_hashes_.resize(static_cast<std::size_t>(counted_.count()));
    TRY(for_each_slab("counting", counted_, {}, [&](const Slab& slab, mesh::Mesh& /*part*/) -> Result<void> {
      slab_hash(slab.bk) = hash_of(slab);
      for (int bj = 0; bj < bricks_.rows_y(); ++bj) count_brick_row(slab, bj);
      const std::lock_guard lock(mutex);
      if (slab.bk < own_.end) counted_sides_.add(slab.sides);
      return {};
    }));
    const glm::u64vec3 dims(view_.dims);
    stats.samples_classified = dims.x * dims.y * dims.z;
    return {};
  }

  [[nodiscard]] std::uint64_t& slab_hash(int bk) { return slab_hashes_[static_cast<std::size_t>(bk - counted_.begin)]; }
  [[nodiscard]] std::uint64_t hash_of(const Slab& slab) const {
    return slab.masks.hash(kBrickRows * slab.bk, std::min(kBrickRows * slab.bk + kSlabSlices, view_.dims.z));
  }

  // Returns whether the masks of a slab are equal to the counted masks. If not, the counts must not be used.
  [[nodiscard]] bool is_as_counted(const Slab& slab) {
    if (masks_ || hash_of(slab) == slab_hash(slab.bk)) return true;
    samples_changed_ = true;
    return false;
  }

  // Returns word `w` of the mask of row (j, k), zero behind the last.
  [[nodiscard]] std::uint64_t mask_word(int j, int k, int w) const {
    if (masks_) return masks_->row(j, k)[w];
    const int rest = view_.dims.x - 64 * w;
    std::uint64_t nan = 0;
    return rest > 0 ? InsideClassifier<T>(threshold_)(view_.row(j, k) + 64 * w, std::min(rest, 64), nan) : 0;
  }

  [[nodiscard]] Result<void> check_samples() const {
    if (!samples_changed_) return {};
    return fail(ErrorCode::input, fmt::format("{}: the samples changed during the extraction", field_.source),
                "wait until the program that writes the file has finished");
  }

  // Returns the number of slices in the slabs before `bk`.
  [[nodiscard]] int slices_below(int bk) const { return std::min(kBrickRows * bk, view_.dims.z); }

  // Runs f(bj, bk) for every row of bricks, in parallel. Releases the pages of each slab after its last row.
  template <class F>
  void for_each_brick_row(const char* stage, const F& f) {
    const int rows_y = bricks_.rows_y();
    std::vector<std::atomic<int>> rows_done(static_cast<std::size_t>(bricks_.rows_z()));
    const int brick_rows = rows_y * bricks_.rows_z();
    context_.progress().begin(stage, static_cast<std::uint64_t>(brick_rows));
    for_each_index(brick_rows, [&](int b) {
      const int bk = b / rows_y;
      f(b % rows_y, bk);
      if (++rows_done[static_cast<std::size_t>(bk)] == rows_y) leave(bk);
      context_.progress().advance(1);
    });
  }

  void leave(int bk) const { leave_slab(view_, bk, options_.smooth_normals ? 2 : 1); }

  // Runs f(j, k) for every row of samples in a row of bricks.
  template <class F>
  void for_each_row(int bj, int bk, const F& f) {
    const int end_j = std::min(kBrickRows * (bj + 1), view_.dims.y);
    const int end_k = std::min(kBrickRows * (bk + 1), view_.dims.z);
    for (int k = kBrickRows * bk; k < end_k; ++k) {
      for (int j = kBrickRows * bj; j < end_j; ++j) f(j, k);
    }
  }

  [[nodiscard]] CellRow cell_row(const DenseMasks& masks, int j, int k) const {
    CellRow row;
    row.origin = {0, j, k};
    for (int r = 0; r < 4; ++r) {
      const int y = j + (r & 1);
      const int z = k + (r >> 1);
      row.bits[static_cast<std::size_t>(r)] = y < view_.dims.y && z < view_.dims.z ? masks.row(y, z) : nullptr;
    }
    row.samples = view_.dims.x;
    row.crossed_bricks = bricks_.row(j / kBrickRows, k / kBrickRows);
    return row;
  }

  // Counts the vertices and triangles: here of all rows, below of a row of bricks. Returns how many cells are left out.
  std::uint64_t count_rows() {
    std::atomic<std::uint64_t> left_out{0};
    for_each_brick_row("counting", [&](int bj, int bk) {
      left_out.fetch_add(count_brick_row(slab_in_memory(bk), bj), std::memory_order_relaxed);
    });
    return left_out.load();
  }

  std::uint64_t count_brick_row(const Slab& slab, int bj) {
    std::uint64_t left_out = 0;
    const SampleChooser<T> chooser = chooser_in(slab);
    bricks_.mark_crossed(slab.masks, bj, slab.bk);
    for_each_row(bj, slab.bk, [&](int j, int k) {
      const RowCounts counts = count_cells(*drawings_, cell_row(slab.masks, j, k), chooser);
      const std::size_t row = rows_.index(j, k);
      std::copy_n(counts.vertices.begin(), directions_, rows_.vertices(row));
      rows_.triangles(row) = counts.cells.triangles;
      left_out += counts.cells.left_out;
      row_ends_.mark(slab.masks, j, k);
    });
    return left_out;
  }

  // Turns counts into first numbers. Returns the sizes of the whole mesh, also if ranks share it.
  Result<MeshSizes> place_rows(ExtractStats& stats) {
    rows_.sum();
    SharedCounts counts;
    counts.all = {rows_.counted_below(slices_below(own_.end)), bricks_.count_crossed(own_), counted_sides_};
    if (ranks_ != nullptr) counts = TRY(share_counts(counts.all, *ranks_));
    stats.bricks_visited = counts.all.bricks_crossed;
    if (!masks_) {
      sides_ = counts.all.sides.boundary;
      TRY(check_nan(counts.all.sides.nan, stats));
    }
    rows_.place(counts.before.sizes);
    return counts.all.sizes;
  }

  [[nodiscard]] MeshSizes slab_sizes(int bk) const {
    const MeshSizes first = rows_.numbers_at(slices_below(bk));
    const MeshSizes end = rows_.numbers_at(slices_below(bk + 1));
    return {end.vertices - first.vertices, end.triangles - first.triangles};
  }

  // Writes the vertices and triangles of a row of bricks to a mesh that begins with vertex and triangle `first`, if the
  // mesh has memory for them.
  void emit_brick_row(mesh::Mesh& mesh, const MeshSizes& first, const Slab& slab, int bj) {
    const bool is_crossed = bricks_.is_row_crossed(bj, slab.bk);
    if (is_crossed && !mesh.positions.empty()) emit_vertices(mesh, first.vertices, slab, bj);
    if (is_crossed && !mesh.triangles.empty())
      for_each_row(bj, slab.bk, [&](int j, int k) { emit_triangles(mesh, first.triangles, slab, j, k); });
    if (masks_) leave_brick_row(view_, slab.bk, bj);
  }

  void emit_vertices(mesh::Mesh& mesh, std::uint64_t first, const Slab& slab, int bj) {
    EdgeList edges(directions_, view_.dims.x);
    VertexWriter writer({placement_, rule_, field_.scale}, mesh, 0);
    VertexBatch& batch = writer.batch();
    for_each_row(bj, slab.bk, [&](int j, int k) {
      // The rows of a slice have consecutive numbers within a brick row, but not from slice to slice.
      if (j == kBrickRows * bj) writer.continue_at(rows_.vertices(rows_.index(j, k))[0] - first);
      const std::size_t row = rows_.index(j, k);
      if (rows_.vertices(row)[0] == rows_.vertices(row + 1)[0]) return;
      list_edges(*drawings_, cell_row(slab.masks, j, k), edges);
      for (int d = 0; d < directions_; ++d) {
        const int direction = table_.directions[static_cast<std::size_t>(d)];
        for (const std::int32_t* x = edges.begin(d); x != edges.end(d);) {
          const auto room = static_cast<std::ptrdiff_t>(VertexBatch::kCapacity - batch.count);
          const std::int32_t* end = x + std::min(room, edges.end(d) - x);
          add_edges(slab.whole, batch, std::span(x, end), j, k, direction, writer.wants_gradients());
          x = end;
          writer.flush_if_full();
        }
      }
    });
    writer.flush();
  }

  void add_edges(const DenseView<T>& whole, VertexBatch& batch, std::span<const std::int32_t> positions, int j, int k,
                 int direction, bool gradients) const {
    const glm::ivec3 low = region_.min + glm::ivec3(0, j, k);
    const glm::ivec3 step = direction_step(direction);
    const T* ends[2] = {whole.row(low.y, low.z) + low.x, whole.row(low.y + step.y, low.z + step.z) + low.x + step.x};
    const int first = batch.count;
    int i = first;
    for (const std::int32_t x : positions) {
      batch.value[0][i] = static_cast<double>(ends[0][x]);
      batch.value[1][i] = static_cast<double>(ends[1][x]);
      batch.low[0][i] = low.x + x;
      batch.low[1][i] = low.y;
      batch.low[2][i] = low.z;
      batch.direction[i] = direction;
      ++i;
    }
    batch.count = i;
    if (!gradients) return;
    for (int end = 0; end < 2; ++end) {
      const glm::ivec3 row = low + end * step;
      for (i = first; i < batch.count; ++i) {
        const glm::dvec3 g =
            sample_gradient(whole, {row.x + positions[static_cast<std::size_t>(i - first)], row.y, row.z});
        for (int axis = 0; axis < 3; ++axis) batch.gradient[end][axis][i] = g[axis];
      }
    }
  }

  void emit_triangles(mesh::Mesh& mesh, std::uint64_t first_triangle, const Slab& slab, int j, int k) {
    const std::size_t index = rows_.index(j, k);
    if (rows_.triangles(index) == rows_.triangles(index + 1)) return;
    const auto first_numbers = [&]<int kDirections>(std::integral_constant<int, kDirections>) {
      std::array<std::uint32_t, kMaxStreams> first{};
      std::size_t s = 0;
      for (const auto& stream : kCellStreams<kDirections>.streams) {
        first[s++] = rows_.vertices(
            rows_.index(j + (stream.row & 1), k + (stream.row >> 1)))[direction_index<kDirections>(stream.direction)];
      }
      return first;
    };
    const auto first = directions_ == 3 ? first_numbers(std::integral_constant<int, 3>{})
                                        : first_numbers(std::integral_constant<int, 7>{});
    const auto room = mesh.triangles.span().subspan(rows_.triangles(index) - first_triangle,
                                                    rows_.triangles(index + 1) - rows_.triangles(index));
    const SampleChooser<T> chooser = chooser_in(slab);
    if (!write_cells(*drawings_, cell_row(slab.masks, j, k), chooser, first, room)) samples_changed_ = true;
  }

  const field::ScalarField& field_;
  const ExtractOptions& options_;
  const Context& context_;
  Ranks* ranks_;  // share the volume slab by slab, without masks of all samples; null: this process does all of it
  InsideRule rule_;
  const field::SampleLayers* layers_;  // null if all samples are in memory; else whole_ and view_ have no samples
  DenseView<T> whole_;
  DenseView<T> view_;  // view of the region
  field::IndexBox region_;
  const CaseTable& table_;
  int directions_;
  OutputPlacement placement_;
  std::optional<DenseMasks> masks_;         // of all samples; nullopt: passes compare the samples slab by slab
  InsideThreshold<T> threshold_{};          // if there are no masks of all samples
  std::vector<std::uint64_t> slab_hashes_;  // of the counted masks, if there are no masks of all samples
  SliceSides counted_sides_;                // of the own slabs, if there are no masks of all samples
  BoundarySides sides_;
  SlabRange own_;      // of this rank
  SlabRange counted_;  // and the next rank's first slab
  BrickFlags bricks_;
  bool has_holes_ = false;                    // NaN samples were found under NanPolicy::hole
  std::atomic<bool> samples_changed_{false};  // the mapped file changed between two reads
  std::optional<CellDrawings> drawings_;
  Reservation rows_memory_;  // for the bricks and the table below
  RowTable rows_;
  RowEnds row_ends_;  // if a cap needs them
};

}  // namespace

Result<Extraction> extract_dense(const field::ScalarField& field, const field::DenseSamples& samples,
                                 const ExtractOptions& options, const Context& context) {
  const auto region = TRY(dense_region(field, samples, options));
  return visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) -> Result<Extraction> {
    if (Ranks* ranks = options.sink != nullptr ? options.sink->ranks() : nullptr; ranks != nullptr) {
      DenseExtraction<T> share(field, samples, region, std::nullopt, options, context, ranks);
      auto extraction = extract_surface(field, options, share, context);
      if (!extraction || extraction->taken) return extraction;
      ranks->work_alone("the mesh is small, or the writer, NaN samples or vertices at equal positions need it whole");
      if (!ranks->is_first()) return leave_to_first_rank();
    }
    // Without masks of all samples, each sample is compared twice. Holes need the masks.
    const glm::ivec3 dims(region.dims());
    const bool is_short = DenseMasks::bytes(dims) > context.memory().left() / 2 && options.nan != NanPolicy::hole;
    std::optional<DenseMasks> masks;
    if (!is_short && samples.layers == nullptr) masks = TRY(make_masks(field, dims, context));
    DenseExtraction<T> surface(field, samples, region, std::move(masks), options, context);
    return extract_surface(field, options, surface, context);
  });
}

}  // namespace isoextract::extract
