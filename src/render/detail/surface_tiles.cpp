#include "render/detail/surface_tiles.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>

#include <fmt/format.h>

#include "base/finite.hpp"
#include "base/parallel.hpp"

namespace isoextract::render::detail {
namespace {

bool is_before(double depth_a, std::uint32_t triangle_a, double depth_b, std::uint32_t triangle_b) {
  return std::tie(depth_a, triangle_a) < std::tie(depth_b, triangle_b);
}

// The plane through the eye and an edge; tells which rays pass the edge on the triangle's side. Two triangles that
// share the edge have planes that are opposite, bit for bit, so a ray on the plane belongs to exactly one of them.
class EdgePlane {
 public:
  EdgePlane(const glm::dvec3& from, const glm::dvec3& to, double facing)
      : normal_(facing * glm::cross(from, to)),
        owns_edge_(normal_.x > 0 || (normal_.x == 0 && (normal_.y > 0 || (normal_.y == 0 && normal_.z > 0)))) {}

  [[nodiscard]] double side(const glm::dvec3& direction) const { return glm::dot(normal_, direction); }
  [[nodiscard]] bool has(double side) const { return side > 0 || (side == 0 && owns_edge_); }

 private:
  glm::dvec3 normal_;
  bool owns_edge_;
};

}  // namespace

void TileFragments::clear() {
  opaque_.fill({});
  fragments_.clear();
  met_ = 0;
}

Result<void> TileFragments::add(const Fragment& fragment) {
  if (fragments_.size() == fragments_.capacity()) {
    const std::size_t wanted = std::max(2 * fragments_.capacity(), 2 * kPixels);
    auto memory = TRY(context_.reserve(wanted * sizeof(Fragment), "the surface layers of a picture"));
    fragments_.reserve(wanted);
    memory_ = std::move(memory);
  }
  fragments_.push_back(fragment);
  return {};
}

void TileFragments::sort() {
  std::ranges::sort(fragments_, [](const Fragment& a, const Fragment& b) {
    return std::tie(a.pixel, a.depth, a.triangle) < std::tie(b.pixel, b.depth, b.triangle);
  });
  std::size_t next = 0;
  for (std::size_t pixel = 0; pixel < kPixels; ++pixel) {
    begin_[pixel] = next;
    while (next < fragments_.size() && fragments_[next].pixel == pixel) ++next;
  }
  begin_[kPixels] = next;
}

PixelBox SurfaceTiles::pixels_of(const Corners& corners, const PixelBox& within) const {
  const auto& [a, b, c] = corners;
  const double nearest = -std::max({a.z, b.z, c.z});
  const double farthest = -std::min({a.z, b.z, c.z});
  if (!is_finite(a + b + c) || farthest < near_ || nearest > far_) return {};
  if (nearest < near_) return within;
  const glm::dvec2 p = view_->pixel_of(a);
  const glm::dvec2 q = view_->pixel_of(b);
  const glm::dvec2 r = view_->pixel_of(c);
  // Pixel centers are at half pixels; adds one pixel for rounding.
  const glm::dvec2 low = glm::floor(glm::min(p, glm::min(q, r)) - 0.5);
  const glm::dvec2 high = glm::ceil(glm::max(p, glm::max(q, r)) + 0.5);
  const auto clamped = [&](const glm::dvec2& v) {
    return glm::ivec2(glm::clamp(v, glm::dvec2(within.min), glm::dvec2(within.max)));
  };
  return {clamped(low), clamped(high)};
}

Result<SurfaceTiles> SurfaceTiles::sort(const SurfaceView& view, const Camera& camera, const PictureSize& size,
                                        const Context& context) {
  SurfaceTiles tiles(view, camera, size);
  const std::uint64_t count = view.triangles();
  if (count == 0) return tiles;
  if (count > std::numeric_limits<std::uint32_t>::max()) {
    return fail(ErrorCode::input, fmt::format("expected at most {} triangles in a picture, found {}",
                                              std::numeric_limits<std::uint32_t>::max(), count));
  }
  const PixelBox whole{{0, 0}, {size.width, size.height}};
  const auto each_tile = [&](std::size_t triangle, const auto& f) {
    const PixelBox pixels = tiles.pixels_of(view.corners(triangle), whole);
    if (!pixels.empty()) tiles.grid_.each_in(pixels, f);
  };
  const auto entries = reduce_ranges(
      count, 4096, std::uint64_t{0},
      [&](std::size_t begin, std::size_t end, std::uint64_t sum) {
        for (std::uint64_t t = begin; t != end; ++t) each_tile(t, [&](std::size_t) { ++sum; });
        return sum;
      },
      std::plus<>{});
  using Triangles = mesh::Buckets<std::uint32_t>;
  tiles.memory_ = TRY(context.reserve(Triangles::bytes(entries, tiles.grid_.count()), "the triangles of a picture"));
  tiles.triangles_.emplace(count, tiles.grid_.count(), [&](std::size_t triangle, const auto& put) {
    each_tile(triangle, [&](std::size_t tile) { put(tile, static_cast<std::uint32_t>(triangle)); });
  });
  return tiles;
}

Result<void> SurfaceTiles::draw(std::size_t number, TileFragments& fragments) const {
  fragments.clear();
  if (!triangles_) {
    fragments.sort();
    return {};
  }
  const Tile tile = grid_.at(number);
  const auto draw_triangle = [&](std::uint32_t triangle, std::size_t surface, const auto& found) -> Result<void> {
    const Corners corners = view_->corners(surface, triangle);
    const auto& [a, b, c] = corners;
    const double volume = glm::dot(a, glm::cross(b, c));
    if (!(std::abs(volume) > 0)) return {};  // edge-on
    const double facing = volume > 0 ? 1 : -1;
    const EdgePlane opposite_a(b, c, facing);
    const EdgePlane opposite_b(c, a, facing);
    const EdgePlane opposite_c(a, b, facing);
    const PixelBox pixels = pixels_of(corners, {tile.min, tile.max});
    for (int y = pixels.min.y; y < pixels.max.y; ++y) {
      for (int x = pixels.min.x; x < pixels.max.x; ++x) {
        const glm::dvec3 direction = view_->direction(x + 0.5, y + 0.5);
        const double at_a = opposite_a.side(direction);
        const double at_b = opposite_b.side(direction);
        const double at_c = opposite_c.side(direction);
        if (!opposite_a.has(at_a) || !opposite_b.has(at_b) || !opposite_c.has(at_c)) continue;
        // The sum of the corners, weighted by at_a, at_b and at_c, is |volume| times the direction.
        const double depth = std::abs(volume) / (at_a + at_b + at_c);
        if (!(depth >= near_ && depth <= far_)) continue;
        const auto pixel = static_cast<std::uint32_t>(x - tile.min.x + Tile::kSide * (y - tile.min.y));
        TRY(found(pixel, depth));
      }
    }
    return {};
  };
  const auto of_tile = triangles_->at(number);
  bool see_through = false;
  for (const std::uint32_t triangle : of_tile) {
    const std::size_t surface = view_->surface_of(triangle);
    if (!view_->is_opaque(surface)) {
      see_through = true;
      continue;
    }
    auto drawn = draw_triangle(triangle, surface, [&](std::uint32_t pixel, double depth) -> Result<void> {
      ++fragments.met_;
      auto& nearest = fragments.opaque_[pixel];
      if (is_before(depth, triangle, nearest.depth, nearest.triangle)) nearest = {depth, triangle};
      return {};
    });
    if (!drawn) return drawn;
  }
  for (std::size_t i = 0; see_through && i < of_tile.size(); ++i) {
    const std::uint32_t triangle = of_tile[i];
    const std::size_t surface = view_->surface_of(triangle);
    if (view_->is_opaque(surface)) continue;
    auto drawn = draw_triangle(triangle, surface, [&](std::uint32_t pixel, double depth) -> Result<void> {
      ++fragments.met_;
      const auto& nearest = fragments.opaque_[pixel];
      if (!is_before(depth, triangle, nearest.depth, nearest.triangle)) return {};
      return fragments.add({pixel, triangle, depth});
    });
    if (!drawn) return drawn;
  }
  for (std::uint32_t pixel = 0; pixel < TileFragments::kPixels; ++pixel) {
    const auto& nearest = fragments.opaque_[pixel];
    if (!std::isfinite(nearest.depth)) continue;
    TRY(fragments.add({pixel, nearest.triangle, nearest.depth}));
  }
  fragments.sort();
  return {};
}

}  // namespace isoextract::render::detail
