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

#include "base/first_error.hpp"
#include "base/parallel.hpp"
#include "base/stopwatch.hpp"
#include "extract/dense_input.hpp"
#include "extract/detail/brick_flags.hpp"
#include "extract/detail/cell_rows.hpp"
#include "extract/detail/early_vertices.hpp"
#include "extract/detail/row_ends.hpp"
#include "extract/detail/row_table.hpp"
#include "extract/detail/row_vertices.hpp"
#include "extract/detail/sample_chooser.hpp"
#include "extract/detail/slab_countdown.hpp"
#include "extract/detail/slab_hashes.hpp"
#include "extract/detail/slab_shares.hpp"
#include "extract/detail/slab_views.hpp"
#include "extract/detail/slab_workers.hpp"
#include "extract/detail/vertex_batch.hpp"
#include "extract/mapped_slices.hpp"
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
    const auto threshold = find_inside_threshold<T>(rule_, field_.scale);
    // Counting needs to know whether there are holes.
    const bool may_have_holes = field::is_floating_sample<T> && options_.nan == NanPolicy::hole;
    const bool has_slab_for_each_thread = bricks_.rows_z() >= usable_threads();
    if (threshold && !may_have_holes && has_slab_for_each_thread) {
      threshold_ = *threshold;
      return true;
    }
    is_classified_ = true;
    TRY(classify_dense(field_, view_, region_.min, options_, *masks_, stats, context_));
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
    if (!masks_) {
      TRY(count_slabs());
    } else if (is_classified_) {
      stats.hole_cells = count_rows();
    } else {
      TRY(classify_and_count(stats));
    }
    stats.samples_classified = region_.count();
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
      const MeshSizes sizes = sizes_in(rest_of(pass, bk), slab_sizes(bk));
      room.sizes = {std::max(room.sizes.vertices, sizes.vertices), std::max(room.sizes.triangles, sizes.triangles)};
    }
    TRY(for_each_slab("extracting", own_, room, [&](const Slab& slab, mesh::Mesh& part) -> Result<void> {
      const MeshSizes first = rows_.numbers_at(slices_below(slab.bk));
      const mesh::PartPass rest = rest_of(pass, slab.bk);
      const MeshSizes sizes = sizes_in(rest, slab_sizes(slab.bk));
      const bool is_empty = sizes.vertices == 0 && sizes.triangles == 0;
      if (is_empty && !options_.cap) return {};  // the cap of a slab without a surface compares its samples again
      if (!is_as_counted(slab) || is_empty) return check_samples();
      const auto emit = [&](int bj) { emit_brick_row(part, first, slab, bj, sizes.vertices > 0); };
      if (pass.in_order) for_each_index(bricks_.rows_y(), emit);
      for (int bj = 0; bj < bricks_.rows_y() && !pass.in_order; ++bj) emit(bj);
      return deliver_part(sink, rest, part, first, sizes);
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
    const std::uint32_t first = rows_.vertices(rows_.index(p.y, p.z))[table_.index_of(direction)];
    return first + crossed_edges_before(p, direction, [this](int j, int k, int w) { return mask_word(j, k, w); });
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

  // Replaces classify() if there is no memory for masks of all samples. Returns false if no sample can be inside.
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
  Result<void> count_slabs() {
    std::mutex mutex;
    slab_hashes_ = SlabHashes(counted_);
    TRY(for_each_slab("counting", counted_, {}, [&](const Slab& slab, mesh::Mesh& /*part*/) -> Result<void> {
      slab_hashes_.keep(slab.bk, slab.masks);
      for (int bj = 0; bj < bricks_.rows_y(); ++bj) count_brick_row(slab, bj);
      const std::lock_guard lock(mutex);
      if (slab.bk < own_.end) counted_sides_.add(slab.sides);
      return {};
    }));
    return {};
  }

  // Compares the samples, and counts each slab as soon as its samples are compared.
  Result<void> classify_and_count(ExtractStats& stats) {
    early_.emplace(field_, options_, context_, placement_, bricks_.rows_z(),
                   !options_.edge_keys && may_stay(view_, kSlicesAtWork));
    SlabCountdown countdown(view_.dims.z);
    FirstError failure;
    const auto count = [&](int bk) {
      for (int bj = 0; bj < bricks_.rows_y(); ++bj) count_brick_row(slab_in_memory(bk), bj);
      auto done = early_->add(
          bk, rows_.counted_in(slices_below(bk), slices_below(bk + 1)),
          [this](int slab, mesh::Mesh& part) { emit_early_vertices(part, slab); }, [this](int slab) { leave(slab); });
      if (!done) failure.keep(std::move(done.error()));
    };
    stats.nan_samples =
        extract::classify(view_, threshold_, *masks_, &context_.progress(), [&](int k, const SliceSides& slice) {
          if (!slabs_may_stay(view_)) view_.leave_slices(k, k + 1);
          early_->see(slice);
          countdown.tell(k, count);
          return !failure.any() && !context_.cancelled();
        });
    stats.early_vertices = early_->finish();
    stats.counts_while_comparing = true;
    sides_ = masks_->boundary_sides();
    if (failure.error()) return tl::unexpected(std::move(*failure.error()));
    TRY(context_.check());
    return check_nan(stats.nan_samples, stats);
  }

  // Writes the vertices of a slab, before the rows are placed, to a mesh that begins with the first of them.
  void emit_early_vertices(mesh::Mesh& mesh, int bk) {
    EdgeList edges(directions_, view_.dims.x);
    VertexWriter writer({placement_, rule_, field_.scale}, mesh, 0);
    for (int k = slices_below(bk); k < slices_below(bk + 1); ++k) {
      for (int j = 0; j < view_.dims.y; ++j) {
        if (rows_.counted_vertices(rows_.index(j, k)) > 0) emit_row(writer, edges, slab_in_memory(bk), j, k);
      }
      if (!slabs_may_stay(view_)) view_.leave_slices(std::max(k - 1, slices_below(bk)), k);
    }
    writer.flush();
  }

  // Returns the arrays of a slab that the sink has yet to get in this pass.
  [[nodiscard]] mesh::PartPass rest_of(mesh::PartPass pass, int bk) const {
    if (early_ && early_->is_delivered(bk)) pass.positions = pass.normals = false;
    return pass;
  }

  // Returns whether the masks of a slab are equal to the counted masks. If not, the counts must not be used.
  [[nodiscard]] bool is_as_counted(const Slab& slab) {
    if (masks_ || slab_hashes_.is_kept(slab.bk, slab.masks)) return true;
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
    return extract::cell_row(masks, bricks_, view_.dims, j, k);
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
  void emit_brick_row(mesh::Mesh& mesh, const MeshSizes& first, const Slab& slab, int bj, bool has_vertices = true) {
    const bool is_crossed = bricks_.is_row_crossed(bj, slab.bk);
    if (is_crossed && has_vertices && !mesh.positions.empty()) emit_vertices(mesh, first.vertices, slab, bj);
    if (is_crossed && !mesh.triangles.empty())
      for_each_row(bj, slab.bk, [&](int j, int k) { emit_triangles(mesh, first.triangles, slab, j, k); });
    const bool keeps_pages = early_ && !has_vertices && slabs_may_stay(view_);
    if (masks_ && !keeps_pages) leave_brick_row(view_, slab.bk, bj);
  }

  void emit_vertices(mesh::Mesh& mesh, std::uint64_t first, const Slab& slab, int bj) {
    EdgeList edges(directions_, view_.dims.x);
    VertexWriter writer({placement_, rule_, field_.scale}, mesh, 0);
    for_each_row(bj, slab.bk, [&](int j, int k) {
      // The rows of a slice have consecutive numbers within a brick row, but not from slice to slice.
      if (j == kBrickRows * bj) writer.continue_at(rows_.vertices(rows_.index(j, k))[0] - first);
      const std::size_t row = rows_.index(j, k);
      if (rows_.vertices(row)[0] != rows_.vertices(row + 1)[0]) emit_row(writer, edges, slab, j, k);
    });
    writer.flush();
  }

  // Writes the vertices of row (j, k). `edges` is memory for them.
  void emit_row(VertexWriter& writer, EdgeList& edges, const Slab& slab, int j, int k) const {
    write_row_vertices(table_, *drawings_, cell_row(slab.masks, j, k), slab.whole, region_.min + glm::ivec3(0, j, k),
                       edges, writer);
  }

  void emit_triangles(mesh::Mesh& mesh, std::uint64_t first_triangle, const Slab& slab, int j, int k) {
    const std::size_t index = rows_.index(j, k);
    if (rows_.triangles(index) == rows_.triangles(index + 1)) return;
    const auto first = rows_.first_of_streams(j, k);
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
  std::optional<DenseMasks> masks_;  // of all samples; nullopt: passes compare the samples slab by slab
  InsideThreshold<T> threshold_{};   // if count() compares the samples
  bool is_classified_ = false;       // classify() filled the masks of all samples
  SlabHashes slab_hashes_;           // of the counted masks, if there are no masks of all samples
  SliceSides counted_sides_;         // of the own slabs, if there are no masks of all samples
  BoundarySides sides_;
  SlabRange own_;      // of this rank
  SlabRange counted_;  // and the next rank's first slab
  BrickFlags bricks_;
  bool has_holes_ = false;                    // NaN samples were found under NanPolicy::hole
  std::atomic<bool> samples_changed_{false};  // the mapped file changed between two reads
  std::optional<CellDrawings> drawings_;
  Reservation rows_memory_;  // for the bricks and the table below
  RowTable rows_;
  RowEnds row_ends_;                    // if a cap needs them
  std::optional<EarlyVertices> early_;  // if count() compares the samples of all slabs
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
