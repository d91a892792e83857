#include "extract/detail/dense_extractor.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/first_error.hpp"
#include "base/parallel.hpp"
#include "base/stopwatch.hpp"
#include "extract/asymptotic_decider.hpp"
#include "extract/dense_input.hpp"
#include "extract/detail/cell_rows.hpp"
#include "extract/detail/cell_streams.hpp"
#include "extract/detail/vertex_batch.hpp"
#include "extract/row_bits.hpp"
#include "extract/surface_run.hpp"

namespace isoextract::extract {
namespace {

constexpr int kBrickRows = 8;  // a brick is the 64 cells of a mask word, in 8x8 rows

// Marks the bricks with samples on both sides. The samples of a brick include those that its last cells share with the
// next brick.
class BrickFlags {
 public:
  explicit BrickFlags(const DenseMasks& masks)
      : masks_(masks),
        words_(masks.words()),
        rows_y_((masks.dims().y + kBrickRows - 1) / kBrickRows),
        rows_z_((masks.dims().z + kBrickRows - 1) / kBrickRows) {}

  [[nodiscard]] std::uint64_t bytes() const { return count(); }
  void allocate() { crossed_ = Buffer<std::uint8_t>(count()); }

  [[nodiscard]] int rows_y() const { return rows_y_; }
  [[nodiscard]] int rows_z() const { return rows_z_; }
  [[nodiscard]] std::uint64_t count() const {
    return static_cast<std::uint64_t>(words_) * static_cast<std::uint64_t>(rows_y_) *
           static_cast<std::uint64_t>(rows_z_);
  }
  [[nodiscard]] std::uint64_t count_crossed() const {
    return static_cast<std::uint64_t>(std::count(crossed_.begin(), crossed_.end(), std::uint8_t{1}));
  }

  // Returns one byte a word for brick row (bj, bk).
  [[nodiscard]] const std::uint8_t* row(int bj, int bk) const { return crossed_.data() + offset(bj, bk); }

  void measure(int bj, int bk) {
    std::array<const std::uint64_t*, (kBrickRows + 1) * (kBrickRows + 1)> rows;
    std::size_t count = 0;
    for (int k = kBrickRows * bk; k < std::min(kBrickRows * (bk + 1) + 1, masks_.dims().z); ++k) {
      for (int j = kBrickRows * bj; j < std::min(kBrickRows * (bj + 1) + 1, masks_.dims().y); ++j) {
        rows[count++] = masks_.row(j, k);
      }
    }
    mark_crossed_words(std::span(rows).first(count), masks_.dims().x, crossed_.data() + offset(bj, bk));
  }

 private:
  [[nodiscard]] std::size_t offset(int bj, int bk) const {
    return static_cast<std::size_t>(words_) *
           (static_cast<std::size_t>(bj) + static_cast<std::size_t>(rows_y_) * static_cast<std::size_t>(bk));
  }

  const DenseMasks& masks_;
  int words_;
  int rows_y_;
  int rows_z_;
  Buffer<std::uint8_t> crossed_;
};

template <class T>
class DenseExtraction final : private VariantChooser {
 public:
  DenseExtraction(const field::ScalarField& field, const DenseView<T>& whole, const field::IndexBox& region,
                  DenseMasks masks, const ExtractOptions& options, const Context& context)
      : field_(field),
        options_(options),
        context_(context),
        rule_{field.kind, options.iso},
        whole_(whole),
        view_(part_of(whole, region)),
        region_(region),
        table_(case_table(options.method)),
        directions_(static_cast<int>(table_.directions.size())),
        placement_(output_placement(field, options, {glm::ivec3(0), whole.dims - 1}, region)),
        masks_(std::move(masks)),
        bricks_(masks_) {}

  [[nodiscard]] const OutputPlacement& placement() const { return placement_; }

  Result<bool> classify(ExtractStats& stats) {
    stats.brick = fmt::format("64x{0}x{0} cells", kBrickRows);
    stats.bricks = bricks_.count();
    const auto threshold = TRY(classify_dense(field_, view_, region_.min, options_, masks_, stats, context_));
    has_holes_ = stats.nan_samples != 0 && options_.nan == NanPolicy::hole;
    return threshold.has_value();
  }

  Result<MeshSizes> count(ExtractStats& stats) {
    const Stopwatch watch;
    const std::size_t rows = row_index(0, view_.dims.z) + 1;  // one more for the end
    rows_memory_ =
        TRY(context_.reserve(bricks_.bytes() + rows * (static_cast<std::size_t>(directions_) * sizeof(std::uint32_t) +
                                                       sizeof(std::uint64_t)),
                             fmt::format("{}: the table of its {} rows of samples", field_.source, rows - 1)));
    bricks_.allocate();
    drawings_.emplace(row_drawings(table_, placement_.mirrored(), has_holes_));
    stats.hole_cells = count_rows();
    stats.bricks_visited = bricks_.count_crossed();
    const MeshSizes sizes = place_rows();
    stats.count = watch.elapsed();
    return sizes;
  }

  Result<void> emit(mesh::Mesh& mesh) {
    emit_bricks(mesh);
    return check_samples();
  }

  // A part of the mesh is a slab: the rows of bricks of one index along z, whose vertices have consecutive numbers.
  // Each thread makes one slab after another in the same memory; where memory is short, fewer threads work.
  Result<void> deliver(mesh::MeshSink& sink, const Context& context) {
    const int slabs = bricks_.rows_z();
    MeshSizes largest;
    for (int bk = 0; bk < slabs; ++bk) {
      const MeshSizes sizes = slab_sizes(bk);
      largest = {std::max(largest.vertices, sizes.vertices), std::max(largest.triangles, sizes.triangles)};
    }
    std::vector<Reservation> memory;
    memory.push_back(TRY(reserve_mesh(field_, largest, options_, context)));
    for (const int most = std::min(usable_threads(), slabs); static_cast<int>(memory.size()) < most;) {
      auto another = reserve_mesh(field_, largest, options_, context);
      if (!another) break;
      memory.push_back(std::move(*another));
    }
    context.progress().begin("extracting", static_cast<std::uint64_t>(slabs));
    FirstError failure;
    std::atomic<int> next{0};
    for_each_index(memory.size(), [&](std::size_t /*thread*/) {
      mesh::Mesh part;
      allocate_mesh(part, largest, {}, options_);
      for (int bk = next++; bk < slabs && !failure.any(); bk = next++) {
        auto delivered = deliver_slab(bk, part, sink);
        if (delivered) delivered = context.check();
        if (!delivered) failure.keep(std::move(delivered.error()));
        context.progress().advance(1);
      }
    });
    if (failure.error()) return tl::unexpected(std::move(*failure.error()));
    return check_samples();
  }

  [[nodiscard]] std::optional<field::IndexBox> cap_box() const { return region_; }
  [[nodiscard]] BoundarySides boundary_sides() const { return masks_.boundary_sides(); }
  [[nodiscard]] bool draws_at_boundary() const {
    return extract::draws_at_boundary(
        region_, [this](const glm::ivec3& p) { return inside(p); },
        [this](const glm::ivec3& p) { return std::isnan(value(p)); });
  }
  [[nodiscard]] bool has_holes() const { return has_holes_; }
  [[nodiscard]] bool inside(const glm::ivec3& p) const { return masks_.inside(p - region_.min); }
  [[nodiscard]] double value(const glm::ivec3& p) const {
    return field_.scale(static_cast<double>(whole_.row(p.y, p.z)[p.x]));
  }

  // Returns the number of one vertex by counting; slow, for the few vertices that are not visited in order.
  [[nodiscard]] std::uint32_t edge_vertex(const glm::ivec3& sample, int direction) const {
    const glm::ivec3 p = sample - region_.min;
    const CellRow row = cell_row(p.y, p.z);
    const std::uint64_t* upper = row.bits[static_cast<std::size_t>(direction >> 1)];
    std::uint32_t number = vertex_base(row_index(p.y, p.z))[table_.index_of(direction)];
    for (int w = 0; w <= p.x / 64; ++w) {
      const std::uint64_t ends = (direction & 1) != 0 ? next_bits(upper, w) : upper[w];
      number += static_cast<std::uint32_t>(std::popcount((row.bits[0][w] ^ ends) & bits_below(w, p.x)));
    }
    return number;
  }

 private:
  [[nodiscard]] Result<void> check_samples() const {
    if (!samples_changed_) return {};
    return fail(ErrorCode::input, fmt::format("{}: the samples changed during the extraction", field_.source),
                "wait until the program that writes the file has finished");
  }

  [[nodiscard]] std::size_t row_index(int j, int k) const {
    return static_cast<std::size_t>(j) + static_cast<std::size_t>(view_.dims.y) * static_cast<std::size_t>(k);
  }

  // Runs f(bj, bk) for every row of bricks, in parallel.
  template <class F>
  void for_each_brick_row(const char* stage, const F& f) {
    const int rows_y = bricks_.rows_y();
    const int brick_rows = rows_y * bricks_.rows_z();
    context_.progress().begin(stage, static_cast<std::uint64_t>(brick_rows));
    for_each_index(brick_rows, [&](int b) {
      const int bj = b % rows_y;
      const int bk = b / rows_y;
      f(bj, bk);
      context_.progress().advance(1);
    });
  }

  // Runs f(j, k) for every row of samples in a row of bricks.
  template <class F>
  void for_each_row(int bj, int bk, const F& f) {
    const int end_j = std::min(kBrickRows * (bj + 1), view_.dims.y);
    const int end_k = std::min(kBrickRows * (bk + 1), view_.dims.z);
    for (int k = kBrickRows * bk; k < end_k; ++k) {
      for (int j = kBrickRows * bj; j < end_j; ++j) f(j, k);
    }
  }

  [[nodiscard]] CellRow cell_row(int j, int k) const {
    CellRow row;
    row.origin = {0, j, k};
    for (int r = 0; r < 4; ++r) {
      const int y = j + (r & 1);
      const int z = k + (r >> 1);
      row.bits[static_cast<std::size_t>(r)] = y < view_.dims.y && z < view_.dims.z ? masks_.row(y, z) : nullptr;
    }
    row.samples = view_.dims.x;
    row.crossed_bricks = bricks_.row(j / kBrickRows, k / kBrickRows);
    return row;
  }

  // Returns how many cells NanPolicy::hole leaves out.
  std::uint64_t count_rows() {
    const std::size_t rows = row_index(0, view_.dims.z);
    vertex_base_ = Buffer<std::uint32_t>((rows + 1) * static_cast<std::size_t>(directions_));
    triangle_base_ = Buffer<std::uint64_t>(rows + 1);
    std::atomic<std::uint64_t> left_out{0};
    for_each_brick_row("counting", [&](int bj, int bk) {
      bricks_.measure(bj, bk);
      for_each_row(bj, bk, [&](int j, int k) {
        const RowCounts counts = count_cells(*drawings_, cell_row(j, k), *this);
        const std::size_t row = row_index(j, k);
        std::copy_n(counts.vertices.begin(), directions_, vertex_base(row));
        triangle_base_[row] = counts.cells.triangles;
        if (counts.cells.left_out != 0) left_out.fetch_add(counts.cells.left_out, std::memory_order_relaxed);
      });
    });
    return left_out.load();
  }

  // Returns the first vertex numbers of a row, by direction.
  [[nodiscard]] std::uint32_t* vertex_base(std::size_t row) {
    return vertex_base_.data() + row * static_cast<std::size_t>(directions_);
  }
  [[nodiscard]] const std::uint32_t* vertex_base(std::size_t row) const {
    return vertex_base_.data() + row * static_cast<std::size_t>(directions_);
  }

  // `p` is relative to the region.
  [[nodiscard]] std::optional<unsigned> variant(unsigned cell_case, const glm::ivec3& p) const override {
    return cell_variant_or_hole(table_, cell_case, rule_, has_holes_,
                                [&](int corner) { return value(region_.min + p + direction_step(corner)); });
  }

  // Turns counts into first numbers.
  MeshSizes place_rows() {
    const auto slices = static_cast<std::size_t>(view_.dims.z);
    const std::size_t rows = row_index(0, 1);
    const std::size_t vertices = rows * static_cast<std::size_t>(directions_);
    std::vector<MeshSizes> first(slices);
    for_each_index(slices, [&](std::size_t k) {
      const auto vertex_counts = vertex_base_.span().subspan(k * vertices, vertices);
      const auto triangle_counts = triangle_base_.span().subspan(k * rows, rows);
      first[k] = {std::accumulate(vertex_counts.begin(), vertex_counts.end(), std::uint64_t{0}),
                  std::accumulate(triangle_counts.begin(), triangle_counts.end(), std::uint64_t{0})};
    });
    MeshSizes sizes;
    for (MeshSizes& slice : first) {
      sizes.vertices += std::exchange(slice.vertices, sizes.vertices);
      sizes.triangles += std::exchange(slice.triangles, sizes.triangles);
    }
    for_each_index(slices, [&](std::size_t k) {
      auto vertex = static_cast<std::uint32_t>(first[k].vertices);
      for (std::uint32_t& base : vertex_base_.span().subspan(k * vertices, vertices)) {
        vertex += std::exchange(base, vertex);
      }
      std::uint64_t triangle = first[k].triangles;
      for (std::uint64_t& base : triangle_base_.span().subspan(k * rows, rows)) {
        triangle += std::exchange(base, triangle);
      }
    });
    vertex_base(slices * rows)[0] = static_cast<std::uint32_t>(sizes.vertices);
    triangle_base_[slices * rows] = sizes.triangles;
    return sizes;
  }

  // Returns how many vertices and triangles lie below a slab.
  [[nodiscard]] MeshSizes below_slab(int bk) const {
    const std::size_t row = row_index(0, std::min(kBrickRows * bk, view_.dims.z));
    return {vertex_base(row)[0], triangle_base_[row]};
  }

  void emit_bricks(mesh::Mesh& mesh) {
    std::vector<std::atomic<int>> rows_done(static_cast<std::size_t>(bricks_.rows_z()));
    for_each_brick_row("extracting", [&](int bj, int bk) {
      emit_brick_row(mesh, {}, bj, bk);
      if (++rows_done[static_cast<std::size_t>(bk)] == bricks_.rows_y()) leave_slab(bk);
    });
  }

  void leave_slab(int bk) const { view_.leave_slices(kBrickRows * bk, std::min(kBrickRows * (bk + 1), view_.dims.z)); }

  [[nodiscard]] MeshSizes slab_sizes(int bk) const {
    const MeshSizes first = below_slab(bk);
    const MeshSizes end = below_slab(bk + 1);
    return {end.vertices - first.vertices, end.triangles - first.triangles};
  }

  // Makes the slab at the start of `part` and hands it to the sink.
  Result<void> deliver_slab(int bk, mesh::Mesh& part, mesh::MeshSink& sink) {
    const MeshSizes first = below_slab(bk);
    const MeshSizes sizes = slab_sizes(bk);
    if (sizes.vertices != 0 || sizes.triangles != 0) {
      for (int bj = 0; bj < bricks_.rows_y(); ++bj) emit_brick_row(part, first, bj, bk);
      TRY(sink.take({first.vertices, std::as_const(part.positions).span().first(sizes.vertices),
                     std::as_const(part.normals).span().first(part.normals.empty() ? 0 : sizes.vertices),
                     first.triangles, std::as_const(part.triangles).span().first(sizes.triangles)}));
    }
    leave_slab(bk);
    return {};
  }

  // Writes the vertices and triangles of a row of bricks to a mesh that begins with vertex and triangle `first`.
  void emit_brick_row(mesh::Mesh& mesh, const MeshSizes& first, int bj, int bk) {
    const std::uint8_t* crossed_bricks = bricks_.row(bj, bk);
    if (std::find(crossed_bricks, crossed_bricks + masks_.words(), 1) == crossed_bricks + masks_.words()) return;
    emit_vertices(mesh, first.vertices, bj, bk);
    for_each_row(bj, bk, [&](int j, int k) { emit_triangles(mesh, first.triangles, j, k); });
  }

  void emit_vertices(mesh::Mesh& mesh, std::uint64_t first, int bj, int bk) {
    EdgeList edges(directions_, view_.dims.x);
    VertexWriter writer({placement_, rule_, field_.scale}, mesh, 0);
    VertexBatch& batch = writer.batch();
    for_each_row(bj, bk, [&](int j, int k) {
      // The rows of a slice have consecutive numbers within a brick row, but not from slice to slice.
      if (j == kBrickRows * bj) writer.continue_at(vertex_base(row_index(j, k))[0] - first);
      const std::size_t row = row_index(j, k);
      if (vertex_base(row)[0] == vertex_base(row + 1)[0]) return;
      list_edges(*drawings_, cell_row(j, k), edges);
      for (int d = 0; d < directions_; ++d) {
        const int direction = table_.directions[static_cast<std::size_t>(d)];
        for (const std::int32_t* x = edges.begin(d); x != edges.end(d);) {
          const auto room = static_cast<std::ptrdiff_t>(VertexBatch::kCapacity - batch.count);
          const std::int32_t* end = x + std::min(room, edges.end(d) - x);
          add_edges(batch, std::span(x, end), j, k, direction, writer.wants_gradients());
          x = end;
          writer.flush_if_full();
        }
      }
    });
    writer.flush();
  }

  void add_edges(VertexBatch& batch, std::span<const std::int32_t> positions, int j, int k, int direction,
                 bool gradients) const {
    const glm::ivec3 low = region_.min + glm::ivec3(0, j, k);
    const glm::ivec3 step = direction_step(direction);
    const T* ends[2] = {whole_.row(low.y, low.z) + low.x, whole_.row(low.y + step.y, low.z + step.z) + low.x + step.x};
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
        const glm::dvec3 g = sample_gradient({row.x + positions[static_cast<std::size_t>(i - first)], row.y, row.z});
        for (int axis = 0; axis < 3; ++axis) batch.gradient[end][axis][i] = g[axis];
      }
    }
  }

  // Returns the gradient of the stored numbers at a sample of the whole field: central differences, or one-sided ones
  // of the same order at the data boundary (sample_derivative(), boundary_derivative()).
  [[nodiscard]] glm::dvec3 sample_gradient(const glm::ivec3& p) const {
    const T* center = whole_.row(p.y, p.z) + p.x;
    return {axis_derivative(center, 1, p.x, whole_.dims.x),
            axis_derivative(center, whole_.stride_y, p.y, whole_.dims.y),
            axis_derivative(center, whole_.stride_z, p.z, whole_.dims.z)};
  }

  static double axis_derivative(const T* center, std::int64_t stride, int index, int size) {
    const auto at = [&](int steps) { return static_cast<double>(center[steps * stride]); };
    if (index > 0 && index + 1 < size) return sample_derivative(at(-1), at(0), at(1));
    const int inward = index == 0 ? 1 : -1;
    const double far = size == 2 ? std::numeric_limits<double>::quiet_NaN() : at(2 * inward);
    return inward * boundary_derivative(at(0), at(inward), far);
  }

  void emit_triangles(mesh::Mesh& mesh, std::uint64_t first_triangle, int j, int k) {
    const std::size_t index = row_index(j, k);
    if (triangle_base_[index] == triangle_base_[index + 1]) return;
    const auto first_numbers = [&]<int kDirections>(std::integral_constant<int, kDirections>) {
      std::array<std::uint32_t, kMaxStreams> first{};
      std::size_t s = 0;
      for (const auto& stream : kCellStreams<kDirections>.streams) {
        first[s++] = vertex_base(
            row_index(j + (stream.row & 1), k + (stream.row >> 1)))[direction_index<kDirections>(stream.direction)];
      }
      return first;
    };
    const auto first = directions_ == 3 ? first_numbers(std::integral_constant<int, 3>{})
                                        : first_numbers(std::integral_constant<int, 7>{});
    const auto room = mesh.triangles.span().subspan(triangle_base_[index] - first_triangle,
                                                    triangle_base_[index + 1] - triangle_base_[index]);
    if (!write_cells(*drawings_, cell_row(j, k), *this, first, room)) samples_changed_ = true;
  }

  const field::ScalarField& field_;
  const ExtractOptions& options_;
  const Context& context_;
  InsideRule rule_;
  DenseView<T> whole_;
  DenseView<T> view_;  // view of the region
  field::IndexBox region_;
  const CaseTable& table_;
  int directions_;
  OutputPlacement placement_;
  DenseMasks masks_;
  BrickFlags bricks_;
  bool has_holes_ = false;                    // NaN samples were found under NanPolicy::hole
  std::atomic<bool> samples_changed_{false};  // the mapped file changed between two reads
  std::optional<CellDrawings> drawings_;
  Reservation rows_memory_;  // for the bricks and the arrays below
  // First counts, then the number of the first vertex and triangle; the entry after the last row holds the totals.
  Buffer<std::uint32_t> vertex_base_;    // per row and direction
  Buffer<std::uint64_t> triangle_base_;  // per row
};

}  // namespace

Result<Extraction> extract_dense(const field::ScalarField& field, const field::DenseSamples& samples,
                                 const ExtractOptions& options, const Context& context) {
  const auto region = TRY(dense_region(field, samples, options));
  auto masks = TRY(make_masks(field, glm::ivec3(region.dims()), context));
  return visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) -> Result<Extraction> {
    const DenseView<T> view = dense_view<T>(samples);
    DenseExtraction<T> surface(field, view, region, std::move(masks), options, context);
    return extract_surface(field, options, surface, context);
  });
}

}  // namespace isoextract::extract
