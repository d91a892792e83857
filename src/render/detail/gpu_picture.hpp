// One picture, drawn part by part on a device.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "render/detail/gpu_surfaces.hpp"
#include "render/detail/gpu_tile.hpp"
#include "render/detail/gpu_volume.hpp"

namespace isoextract::render::detail {

// Linked when they are first asked for, and kept for the next picture.
class GpuPrograms {
 public:
  enum class Name { opaque, see_through, rays, rays_volume, rays_surfaces, rays_both };
  static constexpr std::size_t kCount = 6;

  [[nodiscard]] Result<const gl::CellProgram*> get(const gl::GlContext& gl, Name name);
  [[nodiscard]] static Name rays(bool volume, bool surfaces) {
    if (surfaces) return volume ? Name::rays_both : Name::rays_surfaces;
    return volume ? Name::rays_volume : Name::rays;
  }

 private:
  std::array<std::optional<gl::CellProgram>, kCount> programs_;
};

// What is to be drawn; outlives the drawing.
struct GpuTask {
  const gl::GlContext& gl;
  GpuPrograms& programs;
  const Scene& scene;
  const Camera& camera;
  const RenderOptions& options;
  const SurfaceView& view;
  const GpuSurfaces& surfaces;
  const GpuVolume* volume;   // may be null
  std::uint64_t list_bytes;  // as GpuRenderOptions has it
  const Context& context;
};

class GpuPicture {
 public:
  // Of at most this many pixels a part is drawn at a time.
  static constexpr int kTilePixels = 1 << 20;

  [[nodiscard]] static Result<GpuPicture> make(const GpuTask& task, GpuMemory& memory);

  // All pixels of `rendered.picture`, and the statistics but for the bricks.
  [[nodiscard]] Result<void> draw(Rendered& rendered);

 private:
  explicit GpuPicture(const GpuTask& task, GpuMemory& memory) : task_(task), memory_(memory) {}

  [[nodiscard]] Result<void> draw_tile(const PixelBox& tile, Rendered& rendered);
  [[nodiscard]] Result<void> draw_opaque(const PixelBox& tile);
  // How many there are in all; `places_` has each pixel's.
  [[nodiscard]] Result<std::uint64_t> count_fragments(const PixelBox& tile);
  [[nodiscard]] Result<void> list_fragments(const PixelBox& tile, std::uint64_t count);
  [[nodiscard]] Result<void> draw_lists(const PixelBox& tile, bool counting);
  [[nodiscard]] Result<void> cast_rays(const PixelBox& tile, const PixelBox& box, bool volume);
  void set_view(const gl::CellProgram& program, const PixelBox& tile) const;
  void set_clip(const gl::CellProgram& program, const PixelBox& tile) const;

  GpuTask task_;
  GpuMemory& memory_;
  Reservation host_memory_;
  glm::ivec2 tile_size_{1};
  PixelBox within_;                    // that may see the volume
  std::uint64_t most_fragments_ = 0;   // of a part's lists
  std::uint64_t fragments_taken_ = 0;  // what the buffer has room for
  std::optional<GpuTile> targets_;
  gl::GlBuffer met_;
  gl::GlBuffer fragments_;
  std::vector<std::uint32_t> places_;
  std::vector<glm::uvec4> counts_;
};

}  // namespace isoextract::render::detail
