// Which triangles each pixel sees, tile by tile: opaque ones by a z-buffer, and of see-through ones all that are in
// front of it, as lists (Carpenter, "The A-buffer, an antialiased hidden surface method", 1984, without its masks).
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
  std::uint32_t pixel;  // of the tile
  std::uint32_t triangle;
  double depth;  // in units
};

// A square of pixels, cut off at the picture's border.
struct Tile {
  static constexpr int kSide = 32;

  glm::ivec2 min;
  glm::ivec2 max;  // beyond the last
};

// The picture's tiles, row after row.
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
  // Calls f(tile number) for the tiles that have one of these pixels.
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

// The fragments of one tile; keeps its memory for the next.
class TileFragments {
 public:
  explicit TileFragments(const Context& context) : context_(context) {}

  // Those of a pixel of the tile, x + Tile::kSide * y, sorted by depth, then by triangle.
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
  // Finds the triangles of each tile. `view` outlives this; memory is reserved for as long as this lives.
  [[nodiscard]] static Result<SurfaceTiles> sort(const SurfaceView& view, const Camera& camera, const PictureSize& size,
                                                 const Context& context);

  // Of the tile by number, in place of what was there.
  [[nodiscard]] Result<void> draw(std::size_t tile, TileFragments& fragments) const;

 private:
  SurfaceTiles(const SurfaceView& view, const Camera& camera, const PictureSize& size)
      : view_(&view), grid_(size), near_(camera.near_depth / camera.unit()), far_(camera.far_depth / camera.unit()) {}

  // The pixels that may see it.
  [[nodiscard]] PixelBox pixels_of(const Corners& corners, const PixelBox& within) const;

  const SurfaceView* view_;
  TileGrid grid_;
  double near_;
  double far_;
  std::optional<mesh::Buckets<std::uint32_t>> triangles_;  // by tile; nothing where there are no triangles
  Reservation memory_;
};

}  // namespace isoextract::render::detail
