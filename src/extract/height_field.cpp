#include "extract/height_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "extract/mesh_assembly.hpp"
#include "field/sample_type.hpp"
#include "mesh/local_origin.hpp"

namespace isoextract::extract {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint64_t kBytesASample = 16;  // of values_, numbers_ and floor_of_
constexpr double kFloorDepth = 0.1;          // of the default floor, as a fraction of the height range

// Builds the mesh of one field. Quad (i, j) has the lowest corner (i, j). The vertex of a sample has the number in
// numbers_. If two quads touch at the sample only, the quad with the larger y has the next number there.
class HeightMesh {
 public:
  HeightMesh(const field::ScalarField& field, const HeightOptions& heights, const ExtractOptions& options,
             const Context& context)
      : field_(field),
        heights_(heights),
        options_(options),
        context_(context),
        samples_(std::get<field::DenseSamples>(field.samples)),
        width_(samples_.dims.x),
        height_(samples_.dims.y) {}

  Result<Extraction> run() {
    const Stopwatch watch;
    const auto memory =
        TRY(context_.reserve(at(0, height_) * kBytesASample, fmt::format("{}: its heights", field_.source)));
    TRY(read_heights());
    TRY(choose_floor());
    result_.stats.classify = watch.elapsed();
    TRY(context_.check());
    Stopwatch rest;
    number_vertices();
    result_.stats.count = rest.elapsed();
    if (triangles_ == 0) return std::move(result_);
    rest.restart();
    TRY(build());
    result_.stats.emit = rest.elapsed();
    return std::move(result_);
  }

 private:
  using Index = std::size_t;
  [[nodiscard]] Index at(int i, int j) const {
    return static_cast<Index>(j) * static_cast<Index>(width_) + static_cast<Index>(i);
  }

  Result<void> read_heights() {
    values_.resize(at(0, height_));
    std::uint64_t missing = 0;
    std::optional<glm::ivec3> first;
    field::visit_sample_type(samples_.type, [&](auto type) {
      using T = typename decltype(type)::type;
      const auto* const from = static_cast<const T*>(samples_.data);
      for (int j = 0; j < height_; ++j) {
        for (int i = 0; i < width_; ++i) {
          const double value = field_.scale(static_cast<double>(from[at(i, j)]));
          values_[at(i, j)] = value;
          if (!std::isnan(value)) continue;
          ++missing;
          if (!first) first = glm::ivec3(i, j, 0);
        }
      }
    });
    result_.stats.samples_classified = values_.size();
    result_.stats.nan_samples = missing;
    if (missing > 0 && options_.nan == NanPolicy::error) {
      tl::unexpected<Error> error = nan_error(field_, missing, *first);
      error.value().hint = {Remedy::set, Setting::nan_policy, "hole to leave holes around them"};
      return error;
    }
    const auto infinite = std::ranges::find_if(values_, [](double value) { return std::isinf(value); });
    if (infinite == values_.end()) return {};
    const auto index = static_cast<Index>(infinite - values_.begin());
    return fail(ErrorCode::input, fmt::format("{}: expected finite heights, found {} at index ({}, {})", field_.source,
                                              *infinite, index % at(0, 1), index / at(0, 1)));
  }

  Result<void> choose_floor() {
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -lowest;
    for (const double value : values_) {
      if (std::isnan(value)) continue;
      lowest = std::min(lowest, value);
      highest = std::max(highest, value);
    }
    if (!heights_.solid || lowest > highest) return {};
    floor_ = heights_.base.value_or(lowest - (highest > lowest ? kFloorDepth * (highest - lowest) : 1));
    if (floor_ < lowest) return {};
    return fail(ErrorCode::input,
                fmt::format("{}: expected a base below all heights, which are from {} to {}, found {}", field_.source,
                            lowest, highest, floor_),
                {Remedy::change, Setting::height_base});
  }

  // Returns whether quad (i, j) has four heights; false outside the field.
  [[nodiscard]] bool has_quad(int i, int j) const {
    if (i < 0 || j < 0 || i + 1 >= width_ || j + 1 >= height_) return false;
    return !std::isnan(values_[at(i, j)]) && !std::isnan(values_[at(i + 1, j)]) && !std::isnan(values_[at(i, j + 1)]) &&
           !std::isnan(values_[at(i + 1, j + 1)]);
  }

  // Returns how many vertices of the surface a sample has.
  [[nodiscard]] std::uint32_t copies(int i, int j) const {
    const bool low_left = has_quad(i - 1, j - 1);
    const bool low_right = has_quad(i, j - 1);
    const bool high_left = has_quad(i - 1, j);
    const bool high_right = has_quad(i, j);
    if (low_left && high_right && !low_right && !high_left) return 2;
    if (low_right && high_left && !low_left && !high_right) return 2;
    return low_left || low_right || high_left || high_right ? 1 : 0;
  }

  void number_vertices() {
    numbers_.assign(values_.size(), kNone);
    std::uint64_t quads = 0;
    for (int j = 0; j < height_; ++j) {
      for (int i = 0; i < width_; ++i) {
        if (const std::uint32_t count = copies(i, j); count > 0) {
          numbers_[at(i, j)] = static_cast<std::uint32_t>(std::min<std::uint64_t>(vertices_, kNone));
          vertices_ += count;
        }
        if (!has_quad(i, j)) continue;
        ++quads;
        for (const glm::ivec2& step : {glm::ivec2(-1, 0), glm::ivec2(1, 0), glm::ivec2(0, -1), glm::ivec2(0, 1)}) {
          if (!has_quad(i + step.x, j + step.y)) ++rim_;
        }
      }
    }
    const std::uint64_t all = static_cast<std::uint64_t>(width_ - 1) * static_cast<std::uint64_t>(height_ - 1);
    is_whole_ = quads == all;
    result_.stats.hole_cells = heights_.solid ? 0 : all - quads;
    result_.stats.inside_at_boundary = !heights_.solid;
    result_.stats.meets_boundary = !heights_.solid;
    triangles_ = 2 * quads;
    if (heights_.solid) triangles_ += 2 * rim_ + (is_whole_ ? rim_ : 2 * quads);
  }

  // Returns the vertex of sample (i, j) in a quad whose lowest corner is in row qj.
  [[nodiscard]] std::uint32_t vertex(int i, int j, int qj) const {
    return numbers_[at(i, j)] + (qj == j && copies(i, j) == 2 ? 1 : 0);
  }

  Result<void> build() {
    const std::uint64_t floor_vertices = !heights_.solid ? 0 : is_whole_ ? rim_ + 1 : vertices_;
    const MeshSizes sizes{vertices_ + floor_vertices, triangles_};
    TRY(check_vertex_count(field_, sizes));
    auto memory = TRY(reserve_mesh(field_, sizes, options_, context_));
    mesh::Mesh& mesh = result_.mesh;
    allocate_mesh(mesh, sizes, {}, options_);
    TRY(place_origin());
    mirrored_ = glm::determinant(options_.output_from_index.linear) < 0;
    std::uint64_t next = vertices_;
    for (int j = 0; j < height_; ++j) {
      for (int i = 0; i < width_; ++i) {
        const std::uint32_t count = copies(i, j);
        for (std::uint32_t copy = 0; copy < count; ++copy) put(numbers_[at(i, j)] + copy, i, j, values_[at(i, j)]);
      }
      TRY(context_.check());
    }
    if (heights_.solid) {
      floor_of_.assign(is_whole_ ? static_cast<Index>(vertices_) : 0, kNone);
      for (int j = 0; j < height_; ++j) {
        for (int i = 0; i < width_; ++i) {
          if (is_whole_ && !is_on_rim(i, j)) continue;
          const std::uint32_t count = copies(i, j);
          for (std::uint32_t copy = 0; copy < count; ++copy) {
            const std::uint32_t top = numbers_[at(i, j)] + copy;
            if (is_whole_) floor_of_[top] = static_cast<std::uint32_t>(next);
            put(next++, i, j, floor_);
          }
        }
      }
      if (is_whole_) put(next++, (width_ - 1) / 2.0, (height_ - 1) / 2.0, floor_);
    }
    for (int j = 0; j + 1 < height_; ++j) {
      for (int i = 0; i + 1 < width_; ++i) {
        if (has_quad(i, j)) add_quad(i, j);
      }
    }
    mesh.memory = std::move(memory);
    return {};
  }

  [[nodiscard]] bool is_on_rim(int i, int j) const { return i == 0 || j == 0 || i + 1 == width_ || j + 1 == height_; }

  [[nodiscard]] std::uint32_t below(std::uint32_t top) const {
    return is_whole_ ? floor_of_[top] : static_cast<std::uint32_t>(vertices_ + top);
  }

  // Chooses the origin of the positions by the bounds of all vertices.
  Result<void> place_origin() {
    glm::dvec3 low(std::numeric_limits<double>::infinity());
    glm::dvec3 high(-low);
    const auto include = [&](int i, int j, double z) {
      const glm::dvec3 position = options_.output_from_index(glm::dvec3(i, j, z));
      low = glm::min(low, position);
      high = glm::max(high, position);
    };
    for (int j = 0; j < height_; ++j) {
      for (int i = 0; i < width_; ++i) {
        if (numbers_[at(i, j)] == kNone) continue;
        include(i, j, values_[at(i, j)]);
        if (heights_.solid) include(i, j, floor_);
      }
    }
    result_.mesh.origin = mesh::choose_local_origin(low, high);
    constexpr double kMost = std::numeric_limits<float>::max();
    const glm::dvec3 farthest = glm::max(glm::abs(low - result_.mesh.origin), glm::abs(high - result_.mesh.origin));
    if (glm::all(glm::lessThanEqual(farthest, glm::dvec3(kMost)))) return {};
    return fail(ErrorCode::input,
                fmt::format("{}: its coordinates are outside the range of float32 positions", field_.source),
                {Remedy::change, Setting::scale});
  }

  void put(std::uint64_t vertex, double i, double j, double z) {
    result_.mesh.positions[vertex] = options_.output_from_index(glm::dvec3(i, j, z)) - result_.mesh.origin;
  }

  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    result_.mesh.triangles[added_++] = mirrored_ ? glm::uvec3(a, c, b) : glm::uvec3(a, b, c);
  }

  // Adds the triangles of a quad, and of the walls and the floor below it.
  void add_quad(int i, int j) {
    const std::uint32_t a = vertex(i, j, j);
    const std::uint32_t b = vertex(i + 1, j, j);
    const std::uint32_t c = vertex(i + 1, j + 1, j);
    const std::uint32_t d = vertex(i, j + 1, j);
    add_triangle(a, b, c);
    add_triangle(a, c, d);
    if (!heights_.solid) return;
    if (!is_whole_) {
      add_triangle(below(a), below(c), below(b));
      add_triangle(below(a), below(d), below(c));
    }
    if (!has_quad(i, j - 1)) add_wall(a, b);
    if (!has_quad(i + 1, j)) add_wall(b, c);
    if (!has_quad(i, j + 1)) add_wall(c, d);
    if (!has_quad(i - 1, j)) add_wall(d, a);
  }

  // Adds the wall below the rim edge from `a` to `b`, counter-clockwise around the surface. In a whole field, also adds
  // the floor triangle at this edge.
  void add_wall(std::uint32_t a, std::uint32_t b) {
    add_triangle(a, below(a), below(b));
    add_triangle(a, below(b), b);
    if (!is_whole_) return;
    const auto middle = static_cast<std::uint32_t>(vertices_ + rim_);
    add_triangle(below(b), below(a), middle);
  }

  const field::ScalarField& field_;
  const HeightOptions& heights_;
  const ExtractOptions& options_;
  const Context& context_;
  const field::DenseSamples& samples_;
  int width_;
  int height_;
  std::vector<double> values_;
  std::vector<std::uint32_t> numbers_;   // first vertex of each sample
  std::vector<std::uint32_t> floor_of_;  // of a whole field: the floor vertex below each vertex of the rim
  double floor_ = 0;
  std::uint64_t vertices_ = 0;  // of the surface
  std::uint64_t triangles_ = 0;
  std::uint64_t rim_ = 0;  // number of rim edges; in a whole field also of rim vertices
  std::uint64_t added_ = 0;
  bool is_whole_ = false;  // no holes
  bool mirrored_ = false;
  Extraction result_;
};

}  // namespace

Result<Extraction> extract_heights(const field::ScalarField& field, const HeightOptions& heights,
                                   const ExtractOptions& options, const Context& context) {
  TRY(check_request(field, options));
  if (options.smooth_normals || options.edge_keys) {
    return fail(ErrorCode::usage,
                fmt::format("{}: a surface of heights has neither smooth normals nor edge keys", field.source));
  }
  const auto* const dense = std::get_if<field::DenseSamples>(&field.samples);
  if (dense == nullptr || dense->dims.z != 1) {
    const std::string found = dense == nullptr
                                  ? "a sparse grid"
                                  : fmt::format("{} x {} x {} samples", dense->dims.x, dense->dims.y, dense->dims.z);
    return fail(ErrorCode::input,
                fmt::format("{}: expected a field of heights, with one sample along z, found {}", field.source, found),
                {Remedy::leave_out, Setting::height_field});
  }
  if (dense->dims.x < 2 || dense->dims.y < 2) {
    return fail(ErrorCode::input, fmt::format("{}: expected at least 2 x 2 heights, found {} x {}", field.source,
                                              dense->dims.x, dense->dims.y));
  }
  auto extraction = HeightMesh(field, heights, options, context).run();
  if (extraction) extraction->mesh.name = field.name;
  return extraction;
}

}  // namespace isoextract::extract
