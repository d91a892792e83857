#include "extract/dense_extractor.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "base/stopwatch.hpp"
#include "extract/asymptotic_decider.hpp"
#include "extract/border_cap.hpp"
#include "extract/cell_output.hpp"
#include "extract/dense_input.hpp"
#include "extract/row_walk.hpp"
#include "mesh/vertex_fans.hpp"

namespace isoextract {
namespace {

constexpr int kBrickRows = 8;  // a brick: the 64 cells of a mask word, in 8 x 8 rows

// Which bricks have samples on both sides. A brick's samples include those that its last cells share with the next.
class BrickFlags {
 public:
  explicit BrickFlags(const DenseMasks& masks)
      : masks_(masks),
        words_(masks.words()),
        rows_y_((masks.dims().y + kBrickRows - 1) / kBrickRows),
        rows_z_((masks.dims().z + kBrickRows - 1) / kBrickRows),
        crossed_(static_cast<std::size_t>(words_) * static_cast<std::size_t>(rows_y_) *
                 static_cast<std::size_t>(rows_z_)) {}

  [[nodiscard]] int rows_y() const { return rows_y_; }
  [[nodiscard]] int rows_z() const { return rows_z_; }
  [[nodiscard]] std::uint64_t count() const { return crossed_.size(); }
  [[nodiscard]] std::uint64_t count_crossed() const {
    return static_cast<std::uint64_t>(std::count(crossed_.begin(), crossed_.end(), std::uint8_t{1}));
  }

  // For every word of brick row (bj, bk).
  [[nodiscard]] const std::uint8_t* row(int bj, int bk) const { return crossed_.data() + offset(bj, bk); }

  void measure(int bj, int bk) {
    const glm::ivec3 dims = masks_.dims();
    const int end_j = std::min(kBrickRows * (bj + 1) + 1, dims.y);
    const int end_k = std::min(kBrickRows * (bk + 1) + 1, dims.z);
    for (int w = 0; w < words_; ++w) {
      // The word's own samples, and the first of the next word.
      const std::uint64_t own = RowBits::valid(w, dims.x);
      const std::uint64_t shared = 64 * (w + 1) < dims.x ? 1 : 0;
      std::uint64_t any = 0;
      std::uint64_t all = ~std::uint64_t{0};
      for (int k = kBrickRows * bk; k < end_k; ++k) {
        for (int j = kBrickRows * bj; j < end_j; ++j) {
          const std::uint64_t* bits = masks_.row(j, k);
          any |= bits[w] | (bits[w + 1] & shared);
          all &= (bits[w] | ~own) & (bits[w + 1] | ~shared);
        }
      }
      crossed_[offset(bj, bk) + static_cast<std::size_t>(w)] = any != 0 && ~all != 0 ? 1 : 0;
    }
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

// The methods' tables are data; only the number of directions is known to the compiler.
template <class T, int kDirections>
class DenseExtraction {
  using Streams = CellStreams<kDirections>;

 public:
  DenseExtraction(const ScalarField& field, const DenseView<T>& whole, const IndexBox& region,
                  const ExtractOptions& options)
      : field_(field),
        options_(options),
        rule_{field.kind, options.iso},
        whole_(whole),
        view_(part_of(whole, region)),
        region_(region),
        table_(case_table(options.method)),
        streams_(table_),
        placement_(options.output_from_index, {glm::ivec3(0), whole.dims - 1}, field.kind, field.scale),
        masks_(view_.dims),
        bricks_(masks_) {}

  Result<Extraction> run() {
    Extraction result;
    result.mesh.origin = placement_.origin();
    result.stats.brick = fmt::format("64x{0}x{0} cells", kBrickRows);
    result.stats.bricks = bricks_.count();

    if (auto fits = check_placement(field_, placement_); !fits) return tl::unexpected(fits.error());
    const auto threshold = classify_dense(field_, view_, region_.min, options_, masks_, result.stats);
    if (!threshold) return tl::unexpected(threshold.error());
    if (!*threshold) return result;
    has_holes_ = result.stats.nan_samples != 0 && options_.nan == NanPolicy::hole;

    Stopwatch watch;
    count();
    result.stats.bricks_visited = bricks_.count_crossed();
    result.stats.hole_cells = hole_cells_.load();
    const MeshSizes sizes = place_rows();
    if (auto fits = check_mesh_size(field_, sizes, options_); !fits) return tl::unexpected(fits.error());
    BorderCap cap;
    if (options_.cap) {
      cap = make_border_cap(
          {glm::ivec3(0), view_.dims - 1}, options_.method, static_cast<std::uint32_t>(sizes.vertices),
          [&](const glm::ivec3& p) { return masks_.inside(p); },
          [&](const glm::ivec3& p, int direction) { return edge_vertex(p, direction); },
          [&](const glm::ivec3& p) { return rule_.depth(value(region_.min + p)); },
          [&](const glm::ivec3& p) { return has_holes_ && std::isnan(value(region_.min + p)); });
      if (auto fits = check_mesh_size(field_, with_cap(sizes, cap), options_); !fits) {
        return tl::unexpected(fits.error());
      }
    }
    result.stats.count = watch.elapsed();

    watch.restart();
    allocate_mesh(result.mesh, sizes, cap, options_);
    emit(result.mesh);
    append_cap(result.mesh, sizes, cap, {glm::ivec3(0), view_.dims - 1}, region_.min, placement_);
    if (has_holes_) {
      if (auto done = make_one_vertex_a_fan(result.mesh, options_.limits, field_.source); !done) {
        return tl::unexpected(done.error());
      }
    }
    result.stats.emit = watch.elapsed();
    return result;
  }

 private:
  [[nodiscard]] std::size_t row_index(int j, int k) const {
    return static_cast<std::size_t>(j) + static_cast<std::size_t>(view_.dims.y) * static_cast<std::size_t>(k);
  }

  // Runs f(bj, bk) for every row of bricks, in parallel.
  template <class F>
  void for_each_brick_row(const char* stage, const F& f) {
    const int rows_y = bricks_.rows_y();
    const int brick_rows = rows_y * bricks_.rows_z();
    if (options_.progress != nullptr) options_.progress->begin(stage, static_cast<std::uint64_t>(brick_rows));
    tbb::parallel_for(0, brick_rows, [&](int b) {
      const int bj = b % rows_y;
      const int bk = b / rows_y;
      f(bj, bk);
      if (options_.progress != nullptr) options_.progress->advance(1);
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

  void count() {
    const std::size_t rows = row_index(0, view_.dims.z);
    vertex_base_ = Buffer<std::uint32_t>(rows * kDirections);
    triangle_base_ = Buffer<std::uint64_t>(rows);
    for_each_brick_row("counting", [&](int bj, int bk) {
      bricks_.measure(bj, bk);
      for_each_row(bj, bk, [&](int j, int k) { count_row(j, k, bricks_.row(bj, bk)); });
    });
  }

  void count_row(int j, int k, const std::uint8_t* crossed_bricks) {
    std::array<std::uint32_t, kDirections> vertices{};
    std::uint64_t triangles = 0;
    const RowBits bits(masks_, j, k);
    for (int w = 0; w < masks_.words(); ++w) {
      if (crossed_bricks[w] == 0) continue;
      for (const auto& stream : streams_.streams) {
        if (stream.row_y != 0 || stream.row_z != 0) continue;
        vertices[stream.direction_index] += static_cast<std::uint32_t>(std::popcount(bits.crossed(stream, w)));
      }
      if (!bits.has_cells()) continue;
      const RowBits::Corners corners = bits.corners(w);
      for_each_bit(bits.active_cells(corners, w), [&](int cell) {
        const glm::ivec3 p(64 * w + cell, j, k);
        if (has_holes_ && touches_nan(p)) {
          hole_cells_.fetch_add(1, std::memory_order_relaxed);
          return;
        }
        const unsigned v = variant(RowBits::cell_case(corners, cell), p);
        triangles += static_cast<std::uint64_t>(table_.first[v + 1] - table_.first[v]);
      });
    }
    const std::size_t row = row_index(j, k);
    std::copy(vertices.begin(), vertices.end(), vertex_base_.data() + row * kDirections);
    triangle_base_[row] = triangles;
  }

  // What the cell at `p` (relative to the region) draws.
  [[nodiscard]] unsigned variant(unsigned cell_case, const glm::ivec3& p) const {
    return cell_variant(table_, cell_case, rule_,
                        [&](int corner) { return value(region_.min + p + direction_step(corner)); });
  }

  // Whether a corner of the cell at `p` (relative to the region) is not a number.
  [[nodiscard]] bool touches_nan(const glm::ivec3& p) const {
    for (int corner = 0; corner < 8; ++corner) {
      if (std::isnan(value(region_.min + p + direction_step(corner)))) return true;
    }
    return false;
  }

  // Counts become first numbers.
  MeshSizes place_rows() {
    MeshSizes sizes;
    for (std::uint32_t& base : vertex_base_) {
      sizes.vertices += std::exchange(base, static_cast<std::uint32_t>(sizes.vertices));
    }
    for (std::uint64_t& base : triangle_base_) sizes.triangles += std::exchange(base, sizes.triangles);
    return sizes;
  }

  // The number of one vertex, found by counting: for the few that are not met in order. `p` is relative to the region.
  [[nodiscard]] std::uint32_t edge_vertex(const glm::ivec3& p, int direction) const {
    const RowBits bits(masks_, p.y, p.z);
    const auto stream = *std::find_if(streams_.streams.begin(), streams_.streams.end(), [&](const auto& s) {
      return s.direction == direction && s.row_y == 0 && s.row_z == 0;
    });
    std::uint32_t number =
        vertex_base_[row_index(p.y, p.z) * kDirections + static_cast<std::size_t>(stream.direction_index)];
    for (int w = 0; w <= p.x / 64; ++w) {
      number += static_cast<std::uint32_t>(std::popcount(bits.crossed(stream, w) & RowBits::valid(w, p.x)));
    }
    return number;
  }

  void emit(Mesh& mesh) {
    for_each_brick_row("extracting", [&](int bj, int bk) {
      const std::uint8_t* crossed_bricks = bricks_.row(bj, bk);
      if (std::find(crossed_bricks, crossed_bricks + masks_.words(), 1) == crossed_bricks + masks_.words()) return;
      for_each_row(bj, bk, [&](int j, int k) {
        emit_vertices(mesh, j, k, crossed_bricks);
        emit_triangles(mesh, j, k, crossed_bricks);
      });
    });
  }

  void emit_vertices(Mesh& mesh, int j, int k, const std::uint8_t* crossed_bricks) {
    const RowBits bits(masks_, j, k);
    for (const auto& stream : streams_.streams) {
      if (stream.row_y != 0 || stream.row_z != 0) continue;
      std::size_t number =
          vertex_base_[row_index(j, k) * kDirections + static_cast<std::size_t>(stream.direction_index)];
      const glm::ivec3 step = direction_step(stream.direction);
      for (int w = 0; w < masks_.words(); ++w) {
        if (crossed_bricks[w] == 0) continue;
        for_each_bit(bits.crossed(stream, w),
                     [&](int bit) { emit_vertex(mesh, number++, region_.min + glm::ivec3(64 * w + bit, j, k), step); });
      }
    }
  }

  [[nodiscard]] double value(const glm::ivec3& p) const {
    return field_.scale(static_cast<double>(whole_.row(p.y, p.z)[p.x]));
  }

  // `p` and `p + step` are the edge's ends, in indices of the whole field.
  void emit_vertex(Mesh& mesh, std::size_t number, const glm::ivec3& p, const glm::ivec3& step) const {
    write_vertex(
        mesh, number, placement_, rule_, p, step, [&](const glm::ivec3& q) { return value(q); },
        [&](const glm::ivec3& q) { return sample_gradient(q); });
  }

  // Of the stored numbers, at a sample: central differences; at the border of the data one-sided ones of the same
  // order.
  [[nodiscard]] glm::dvec3 sample_gradient(const glm::ivec3& p) const {
    const T* centre = whole_.row(p.y, p.z) + p.x;
    return {axis_derivative(centre, 1, p.x, whole_.dims.x),
            axis_derivative(centre, whole_.stride_y, p.y, whole_.dims.y),
            axis_derivative(centre, whole_.stride_z, p.z, whole_.dims.z)};
  }

  static double axis_derivative(const T* centre, std::int64_t stride, int index, int size) {
    const auto at = [&](int steps) { return static_cast<double>(centre[steps * stride]); };
    if (index > 0 && index + 1 < size) return (at(1) - at(-1)) / 2;
    const int inward = index == 0 ? 1 : -1;
    if (size == 2) return inward * (at(inward) - at(0));
    return inward * (4 * at(inward) - 3 * at(0) - at(2 * inward)) / 2;
  }

  void emit_triangles(Mesh& mesh, int j, int k, const std::uint8_t* crossed_bricks) const {
    const RowBits bits(masks_, j, k);
    if (!bits.has_cells()) return;
    std::array<std::uint32_t, Streams::kStreams> next{};  // the number of each stream's next vertex
    for (int s = 0; s < Streams::kStreams; ++s) {
      const auto& stream = streams_.streams[s];
      next[s] = vertex_base_[row_index(j + stream.row_y, k + stream.row_z) * kDirections +
                             static_cast<std::size_t>(stream.direction_index)];
    }
    glm::uvec3* out = mesh.triangles.data() + triangle_base_[row_index(j, k)];
    for (int w = 0; w < masks_.words(); ++w) {
      if (crossed_bricks[w] == 0) continue;
      std::array<std::uint64_t, Streams::kStreams> crossed;
      for (int s = 0; s < Streams::kStreams; ++s) crossed[s] = bits.crossed(streams_.streams[s], w);
      const RowBits::Corners corners = bits.corners(w);
      for_each_bit(bits.active_cells(corners, w), [&](int cell) {
        std::array<std::array<std::uint32_t, 2>, Streams::kStreams> numbers;  // at the cell's position, and at the next
        for (int s = 0; s < Streams::kStreams; ++s) {
          const auto own = static_cast<std::uint32_t>(crossed[s] >> cell & 1);
          numbers[s] = {next[s], next[s] + own};
          next[s] += own;
        }
        const auto vertex = [&](std::uint8_t edge) {
          const auto& source = streams_.edges[edge];
          return numbers[source.stream][source.next ? 1 : 0];
        };
        const glm::ivec3 p(64 * w + cell, j, k);
        if (has_holes_ && touches_nan(p)) return;
        const unsigned v = variant(RowBits::cell_case(corners, cell), p);
        out = write_cell(table_, v, placement_.mirrored(), vertex, out);
      });
    }
  }

  const ScalarField& field_;
  const ExtractOptions& options_;
  InsideRule rule_;
  DenseView<T> whole_;
  DenseView<T> view_;  // of the region
  IndexBox region_;
  const CaseTable& table_;
  Streams streams_;
  Placement placement_;
  DenseMasks masks_;
  BrickFlags bricks_;
  Buffer<std::uint32_t> vertex_base_;    // per row and direction: first a count, then the first vertex number
  Buffer<std::uint64_t> triangle_base_;  // per row, likewise
  bool has_holes_ = false;               // some samples are NaN, and NanPolicy::hole
  std::atomic<std::uint64_t> hole_cells_{0};
};

}  // namespace

Result<Extraction> extract_dense(const ScalarField& field, const DenseSamples& samples, const ExtractOptions& options) {
  const auto region = dense_region(field, samples, options);
  if (!region) return tl::unexpected(region.error());
  return visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) -> Result<Extraction> {
    const DenseView<T> view = dense_view<T>(samples);
    if (options.method == Method::mc) return DenseExtraction<T, 3>(field, view, *region, options).run();
    return DenseExtraction<T, 7>(field, view, *region, options).run();
  });
}

}  // namespace isoextract
