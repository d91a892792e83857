// Finds the triangles that each pixel sees, tile by tile: the nearest opaque one by a z-buffer, and a list of all
// transparent ones in front of it. This is an A-buffer without masks (Carpenter, "The A-buffer, an antialiased hidden
// surface method", 1984).
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/buckets.hpp"
#include "render/camera.hpp"
#include "render/detail/surface_view.hpp"

namespace isoextract::render::detail {

struct Fragment {
  std::uint32_t pixel;  // number within the tile
  std::uint32_t triangle;
  double depth;  // in units of Camera::unit()
};

// A square of pixels, clipped to the picture.
struct Tile {
  static constexpr int kSide = 32;

  glm::ivec2 min;
  glm::ivec2 max;  // exclusive
};

// The picture's tiles, numbered row by row.
class TileGrid {
 public:
  explicit TileGrid(const PictureSize& size)
      : size_(size),
        across_((size.width + Tile::kSide - 1) / Tile::kSide),
        down_((size.height + Tile::kSide - 1) / Tile::kSide) {}

  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(across_) * static_cast<std::size_t>(down_);
  }
  [[nodiscard]] Tile at(std::size_t number) const {
    const auto n = static_cast<int>(number);
    const glm::ivec2 min = Tile::kSide * glm::ivec2(n % across_, n / across_);
    return {min, glm::min(min + Tile::kSide, glm::ivec2(size_.width, size_.height))};
  }
  // Calls f(tile number) for every tile that overlaps the box.
  template <class F>
  void each_in(const PixelBox& box, const F& f) const {
    for (int y = box.min.y / Tile::kSide; y * Tile::kSide < box.max.y; ++y) {
      for (int x = box.min.x / Tile::kSide; x * Tile::kSide < box.max.x; ++x) {
        f(static_cast<std::size_t>(y) * static_cast<std::size_t>(across_) + static_cast<std::size_t>(x));
      }
    }
  }

 private:
  PictureSize size_;
  int across_;
  int down_;
};

// The fragments of one tile; reuses its memory for the next tile.
class TileFragments {
 public:
  explicit TileFragments(const Context& context) : context_(context) {}

  // Returns the fragments of pixel x + Tile::kSide * y of the tile, sorted by depth, then by triangle.
  [[nodiscard]] std::span<const Fragment> of(std::size_t pixel) const {
    return std::span(fragments_).subspan(begin_[pixel], begin_[pixel + 1] - begin_[pixel]);
  }
  [[nodiscard]] std::uint64_t met() const { return met_; }

 private:
  friend class SurfaceTiles;
  static constexpr std::size_t kPixels = std::size_t{Tile::kSide} * Tile::kSide;

  struct Nearest {
    double depth = std::numeric_limits<double>::infinity();
    std::uint32_t triangle = 0;
  };

  void clear();
  [[nodiscard]] Result<void> add(const Fragment& fragment);
  void sort();

  const Context& context_;
  std::array<Nearest, kPixels> opaque_;
  std::vector<Fragment> fragments_;
  std::array<std::size_t, kPixels + 1> begin_{};
  std::uint64_t met_ = 0;
  Reservation memory_;
};

class SurfaceTiles {
 public:
  // Sorts the triangles into tiles. `view` must outlive the result, which holds the memory reservation. Fails with
  // ErrorCode::input for 2^32 triangles or more, and as Context::reserve() does.
  [[nodiscard]] static Result<SurfaceTiles> sort(const SurfaceView& view, const Camera& camera, const PictureSize& size,
                                                 const Context& context);

  // Replaces `fragments` by the fragments of the tile. Fails as Context::reserve() does.
  [[nodiscard]] Result<void> draw(std::size_t tile, TileFragments& fragments) const;

 private:
  SurfaceTiles(const SurfaceView& view, const Camera& camera, const PictureSize& size)
      : view_(&view), grid_(size), near_(camera.near_depth / camera.unit()), far_(camera.far_depth / camera.unit()) {}

  // Returns the pixels of `within` that may see the triangle.
  [[nodiscard]] PixelBox pixels_of(const Corners& corners, const PixelBox& within) const;

  const SurfaceView* view_;
  TileGrid grid_;
  double near_;
  double far_;
  std::optional<mesh::Buckets<std::uint32_t>> triangles_;  // by tile; unset if there are no triangles
  Reservation memory_;
};

}  // namespace isoextract::render::detail
