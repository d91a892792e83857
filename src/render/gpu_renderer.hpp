// Draws scenes on a GPU through EGL, without a display. Follows the rendering model of renderer.hpp, within the
// tolerance stated there.
//
// The first pass draws opaque surfaces into a framebuffer object, which keeps the nearest triangle of each pixel and
// its depth. Then it counts and lists, per pixel, the transparent fragments in front of this triangle.
// The second pass casts one ray per pixel in GLSL (hybrid ray casting, docs/papers.md). It samples the volume, sorts
// the pixel's list, shades the fragments and composites everything front to back. Pixels outside of the screen bounds
// of the volume use a shorter program.
//
// Dense and sparse volumes are stored alike: bricks of 8 x 8 x 8 cells in an atlas, as table positions in float. Only
// bricks with visible samples are uploaded, so a volume may be longer than the longest texture, and sparse volumes
// never become dense. Rays are computed in double, as on the CPU.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "gl/gpu_device.hpp"
#include "render/renderer.hpp"

namespace isoextract::render {

struct GpuRenderOptions {
  gl::DeviceChoice device;
  // Limit of the device memory for volume, surfaces and picture together; by default three quarters of the device's
  // memory, or no limit if the device does not report its memory.
  std::optional<std::uint64_t> memory_bytes;
  // The part of memory_bytes for lists of transparent fragments, 8 bytes each; the renderer divides a tile that needs
  // more into smaller tiles.
  std::uint64_t list_bytes = 256 << 20;
  bool debug = false;  // for tests: fails with ErrorCode::unavailable if the driver reports a problem

  friend bool operator==(const GpuRenderOptions&, const GpuRenderOptions&) = default;
};

struct GpuRendererAndDevice {
  std::unique_ptr<Renderer> renderer;
  gl::GpuDevice device;
};

// Opens the device. Fails with ErrorCode::unavailable if there is none. Use and destroy the renderer on the calling
// thread.
// Renderer::draw() fails with ErrorCode::unavailable if visible bricks, triangles or one pixel's transparent fragments
// do not fit onto the device, or if a ray needs more samples than the backend or the driver allows. If the device
// renders in software, its memory is also reserved from the context.
[[nodiscard]] Result<GpuRendererAndDevice> make_gpu_renderer(const GpuRenderOptions& options);

}  // namespace isoextract::render
