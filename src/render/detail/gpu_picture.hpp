// Draws one picture tile by tile on a device.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "render/detail/gpu_surfaces.hpp"
#include "render/detail/gpu_tile.hpp"
#include "render/detail/gpu_volume.hpp"

namespace isoextract::render::detail {

// Links each program when it is first used, and keeps it for the next picture.
class GpuPrograms {
 public:
  enum class Name {
    opaque,
    see_through,
    rays,
    rays_volume,
    rays_emission,  // of a volume with an emission
    rays_surfaces,
    rays_both,
    rays_both_emission
  };
  static constexpr std::size_t kCount = 8;

  [[nodiscard]] Result<const gl::ShaderProgram*> get(const gl::GlContext& gl, Name name);
  // `emission` has no effect without a volume.
  [[nodiscard]] static Name rays(bool volume, bool emission, bool surfaces) {
    if (!volume) return surfaces ? Name::rays_surfaces : Name::rays;
    if (emission) return surfaces ? Name::rays_both_emission : Name::rays_emission;
    return surfaces ? Name::rays_both : Name::rays_volume;
  }

 private:
  std::array<std::optional<gl::ShaderProgram>, kCount> programs_;
};

// The input of a drawing; all references must outlive it.
struct GpuTask {
  const gl::GlContext& gl;
  GpuPrograms& programs;
  const Scene& scene;
  const Camera& camera;
  const RenderOptions& options;
  const SurfaceView& view;
  const GpuSurfaces& surfaces;
  const GpuVolume* volume;   // may be null
  std::uint64_t list_bytes;  // GpuRenderOptions::list_bytes
  const Context& context;
};

class GpuPicture {
 public:
  // The largest number of pixels drawn at a time.
  static constexpr int kTilePixels = 1 << 20;

  [[nodiscard]] static Result<GpuPicture> make(const GpuTask& task, GpuMemory& memory);

  // Fills all pixels of `rendered.picture`, and the statistics except the brick counts.
  [[nodiscard]] Result<void> draw(Rendered& rendered);

 private:
  explicit GpuPicture(const GpuTask& task, GpuMemory& memory) : task_(task), memory_(memory) {}

  [[nodiscard]] Result<void> draw_tile(const PixelBox& tile, Rendered& rendered);
  [[nodiscard]] Result<void> draw_opaque(const PixelBox& tile);
  // Returns the number of transparent fragments in the tile; sets `places_` to the index of each pixel's first
  // fragment.
  [[nodiscard]] Result<std::uint64_t> count_fragments(const PixelBox& tile);
  [[nodiscard]] Result<void> list_fragments(const PixelBox& tile, std::uint64_t count);
  [[nodiscard]] Result<void> draw_lists(const PixelBox& tile, bool counting);
  [[nodiscard]] Result<void> cast_rays(const PixelBox& tile, const PixelBox& box, bool volume);
  void set_view(const gl::ShaderProgram& program, const PixelBox& tile) const;
  void set_clip(const gl::ShaderProgram& program, const PixelBox& tile) const;

  GpuTask task_;
  GpuMemory& memory_;
  Reservation host_memory_;
  glm::ivec2 tile_size_{1};
  PixelBox within_;                    // pixels that may see the volume
  std::uint64_t most_fragments_ = 0;   // limit for the lists of one tile
  std::uint64_t fragments_taken_ = 0;  // capacity of the buffer
  std::optional<GpuTile> targets_;
  gl::GlBuffer met_;
  gl::GlBuffer fragments_;
  std::vector<std::uint32_t> places_;
  std::vector<glm::uvec4> counts_;
};

}  // namespace isoextract::render::detail
