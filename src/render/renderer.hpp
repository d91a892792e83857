// The interface of renderers, and the rendering model that every backend implements. Where two backends find the same
// surface fragments in a pixel, its channels agree within 2/255 in linear light.
//
// The model is hybrid ray casting (docs/papers.md) with absorption plus emission (Max, "Optical models for direct
// volume rendering", 1995):
//
// 1. Surfaces produce fragments: depth, straight color, opacity (Surface, ShadingModel). A ray's fragments are sorted
//    by depth, at equal depth by the surface's number in the scene, then by the triangle's.
// 2. The ray enters the volume's box at depth d0 and leaves at d1, both clamped to [near, far]; if d1 <= d0 it misses.
//    With L = length of direction_through(), its length in the box is (d1 - d0) * L world units. It is cut into slabs
//    of length `step` (step_of()) from d0 on. Slab k has depths [d0 + k * step / L, d0 + (k + 1) * step / L]; the last
//    one ends at d1. There are ceil(length / step) slabs, at least one; a remainder that is only rounding adds none.
//    With Volume::emission the ray is first cut where it enters and leaves each of the two boxes, and then each part
//    that lies in a box is cut into slabs as above.
// 3. Every slab, also the shorter last one, has one sample at its middle. The transfer function maps the eight
//    surrounding grid samples to positions in its table (TransferFunction::position()); these are interpolated
//    trilinearly. The table gives a color c and an extinction sigma. A part of the slab of length
//    l * Volume::unit_length has opacity 1 - exp(-sigma * l). In the same way Volume::emission is sampled at the same
//    point of the world and gives light e. A field has no effect outside of its box: there sigma or e is 0.
// 4. Front to back, transmittance T = 1 at first: each part of a slab and each fragment adds T * opacity * color and
//    multiplies T by 1 - opacity. A fragment within a slab divides it in two parts, before and after the fragment,
//    which share the slab's sample; a fragment exactly where two slabs meet divides neither of them. Fragments beyond
//    d1 or before d0 need no sample. A part of a slab also adds the light that it emits and does not absorb itself:
//    T * e * (1 - exp(-sigma * l)) / sigma, or T * e * l where sigma is 0. So with constant sigma and e the result is
//    the exact integral.
// 5. Alpha is 1 - T, whatever is emitted; the background comes last, with T.
// 6. Early termination: once T < termination the ray adds no further samples, fragments or background, and counts as
//    opaque. Without it only T = 0 ends a ray. No channel differs by more than termination times the largest color of
//    the scene, or the brightest light that the emission adds along a ray.
// 7. Empty-space skipping skips a brick only if sigma (of an emission: e) is exactly 0 for all values between the least
//    and the greatest sample of the brick, so no bit of the picture changes. A slab is skipped if both fields are.
//
// This covers the six cases of the hybrid ray casting paper: the ray hits nothing; surface only; volume only; surface
// in front; volume in front; surface inside.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "base/context.hpp"
#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "render/camera.hpp"
#include "render/picture.hpp"
#include "render/scene.hpp"

namespace isoextract::render {

struct RenderOptions {
  static constexpr double kTermination = 1.0 / 512;

  PictureSize size{960, 540};    // each side from 1 to PictureSize::kMaxSide
  double samples_per_voxel = 1;  // per shortest voxel edge; from 1/64 to 64
  bool early_termination = true;
  double termination = kTermination;  // in (0, 1)
  bool empty_space_skipping = true;

  friend bool operator==(const RenderOptions&, const RenderOptions&) = default;
};

// Returns the length of a slab in world units: the shortest voxel edge, also of the emission, divided by
// samples_per_voxel.
[[nodiscard]] double step_of(const Volume& volume, const RenderOptions& options);

// Counts of volume samples and (`fragments`) of surface fragments. With early termination or empty-space skipping,
// backends may count differently. Without both, `samples` is the number of slabs of all rays up to the point where T is
// 0.
struct RenderStatistics {
  std::uint64_t rays = 0;                // rays that hit the volume's box or that of its emission
  std::uint64_t samples = 0;             // slabs of which the volume or its emission was sampled
  std::uint64_t samples_skipped = 0;     // samples skipped in empty bricks
  std::uint64_t samples_terminated = 0;  // samples after the end of their ray (T = 0, or early termination)
  std::uint64_t bricks = 0;              // bricks of 8 x 8 x 8 cells, of the volume and its emission
  std::uint64_t bricks_skipped = 0;      // bricks without visible samples
  std::uint64_t fragments = 0;           // surface fragments, whether visible or hidden by others

  friend bool operator==(const RenderStatistics&, const RenderStatistics&) = default;
};

struct Rendered {
  Picture picture;
  RenderStatistics statistics;
  bool reused_volume = false;  // the volume was prepared for an earlier picture (Renderer::keep())
};

class Renderer {
 public:
  Renderer() = default;
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  virtual ~Renderer() = default;

  // Draws a picture; reserves all host memory from the context. Fails as check() and Context::check() do, with
  // ErrorCode::out_of_memory if memory is short, with ErrorCode::unavailable if the device fails, and for too many
  // triangles. Then the caller must check DenseSamples::lost(): reading samples of a mapped file may have failed.
  [[nodiscard]] virtual Result<Rendered> draw(const Scene& scene, const Camera& camera, const RenderOptions& options,
                                              const Context& context) = 0;

  // Sets the volume that the following pictures share; null for none. The renderer prepares the volume's data (brick
  // ranges, or an upload to the device) for the first picture. It keeps the data and their memory until the next
  // keep(), and prepares them again only if the options require it.
  // The volume, its field, its emission and the Context of draw() must stay valid and unchanged until the next keep().
  // Keeping a volume does not change the pictures.
  virtual void keep(const Volume* volume) = 0;

  // Returns "CPU, " and the name of the processor, or the name of the graphics device.
  [[nodiscard]] virtual std::string device() const = 0;
};

// Makes the reference renderer. It uses all threads of oneTBB; the picture is the same, bit for bit, for any number of
// threads.
[[nodiscard]] std::unique_ptr<Renderer> make_cpu_renderer();

// Checks options, camera and scene as draw() requires them.
[[nodiscard]] Result<void> check(const Scene& scene, const Camera& camera, const RenderOptions& options);

}  // namespace isoextract::render
