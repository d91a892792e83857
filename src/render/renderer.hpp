// What draws a scene, on whatever device. Backends give the same picture within 2/255 of each channel in linear light,
// at pixels where they see the same fragments (Surface).
//
// The model (hybrid ray casting, docs/papers.md; Max, "Optical models for direct volume rendering", 1995, absorption
// plus emission):
//
// 1. Surfaces give fragments: depth, straight colour, opacity (Surface, ShadingModel). A ray's fragments are sorted by
//    depth, those of equal depth by the surface's number in the scene and then by the triangle's.
// 2. The ray enters the volume's box at depth d0 and leaves at d1, both cut to [near, far]; for d1 <= d0 it misses.
//    With L = length of direction_through() the way through the box in world units is (d1 - d0) * L. It is cut into
//    slabs of length `step` (step_of()) from d0 on: slab k has depths [d0 + k * step / L, d0 + (k + 1) * step / L], and
//    the last one ends at d1. There are ceil(way / step) of them, at least one, and none for what is only rounding.
// 3. Every slab has one sample, at the middle of it (of the shorter last one, its own middle): the trilinear
//    interpolant of table positions there, looked up (TransferFunction), gives a colour c and an extinction sigma. A
//    part of length l of the slab, in unit lengths of the volume, has opacity 1 - exp(-sigma * l).
// 4. Front to back, transmittance T = 1 at first: each part of a slab and each fragment adds T * opacity * colour and
//    multiplies T by 1 - opacity. A fragment within a slab divides it in two parts, before and behind, which share the
//    slab's sample; one at a border between slabs lies between them. What lies beyond d1 or before d0 needs no sample.
// 5. Alpha is 1 - T; the background comes last, with T.
// 6. Early termination: once T < termination nothing more is added, fragments and background neither; the ray counts
//    as opaque. Without it only T = 0 ends a ray. So no channel differs by more than termination times the largest
//    colour there is.
// 7. Empty-space skipping leaves out samples only where every lookup between the least and the greatest of the
//    samples around has sigma 0 exactly: no bit of the picture changes.
//
// The six cases of that paper are all of these: ray misses both; surface only; volume only; surface in front; volume in
// front; surface inside.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/words.hpp"
#include "render/camera.hpp"
#include "render/picture.hpp"
#include "render/scene.hpp"

namespace isoextract::render {

struct RenderOptions {
  static constexpr double kTermination = 1.0 / 512;

  PictureSize size{960, 540};    // each side from 1 to PictureSize::kMaxSide
  double samples_per_voxel = 1;  // along the shortest edge of a voxel; from 1/64 to 64
  bool early_termination = true;
  double termination = kTermination;  // in (0, 1)
  bool empty_space_skipping = true;

  friend bool operator==(const RenderOptions&, const RenderOptions&) = default;
};

// The length of a whole step in the world: the shortest edge of a voxel over samples_per_voxel.
[[nodiscard]] double step_of(const Volume& volume, const RenderOptions& options);

// Of the volume, except fragments. Backends may count each in their own way where early termination is on and brick
// borders matter; without both, `samples` is the number of slabs of all rays.
struct RenderStatistics {
  std::uint64_t rays = 0;                // that meet the volume's box
  std::uint64_t samples = 0;             // that were taken
  std::uint64_t samples_skipped = 0;     // left out in empty bricks
  std::uint64_t samples_terminated = 0;  // left out behind what lets no light through
  std::uint64_t bricks = 0;              // of 8 x 8 x 8 cells
  std::uint64_t bricks_skipped = 0;      // in which nothing can be seen
  std::uint64_t fragments = 0;           // of surfaces, that reached the picture or were behind another

  friend bool operator==(const RenderStatistics&, const RenderStatistics&) = default;
};

struct Rendered {
  Picture picture;
  RenderStatistics statistics;
  bool volume_kept = false;  // what the volume needs was made for an earlier picture (Renderer::keep())
};

class Renderer {
 public:
  Renderer() = default;
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  virtual ~Renderer() = default;

  // Reserves the memory of the picture and all else from the context. Fails as check() does, with ErrorCode::input
  // where memory is missing, ErrorCode::unavailable where a device gives up, and as Context::check(). Whether a file
  // lost samples meanwhile is the caller's to ask, afterwards (DenseSamples::lost()).
  [[nodiscard]] virtual Result<Rendered> draw(const Scene& scene, const Camera& camera, const RenderOptions& options,
                                              const Context& context) = 0;

  // Names the volume that pictures from now on share; null: none. What the first of them makes of it, ranges of bricks
  // or an upload, is kept with the memory reserved for it, and made anew only where options ask for something else,
  // until the next call. So long the volume and its field live and stay as they are, and so does the context that is
  // drawn with. Pictures are the same without.
  virtual void keep(const Volume* volume) = 0;

  // "CPU", or what the device is called.
  [[nodiscard]] virtual std::string device() const = 0;
};

// The reference: on all threads that oneTBB has, the same bits for any number of them.
[[nodiscard]] std::unique_ptr<Renderer> make_cpu_renderer();

// Options, camera and scene at once, as draw() asks for them.
[[nodiscard]] Result<void> check(const Scene& scene, const Camera& camera, const RenderOptions& options);

}  // namespace isoextract::render
