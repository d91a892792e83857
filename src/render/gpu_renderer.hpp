// Draws on a GPU, through EGL without a display: the picture of the model (renderer.hpp) within the bound told there.
//
// First pass: opaque surfaces into a framebuffer object, the nearest triangle of each pixel and its depth; then what is
// see-through in front of it, counted and listed for each pixel. Second pass: one ray a pixel of GLSL, which samples
// the volume, sorts the pixel's list, shades what it meets and composites all of it front to back (hybrid ray casting,
// docs/papers.md). Pixels outside of the screen bounds of the volume's corners take a shorter program.
//
// Dense and sparse volumes alike lie on the device as bricks of 8 x 8 x 8 cells in an atlas, as table positions in
// float: only bricks in which something can be seen are there, so no side of a volume is too long for a texture, and
// sparse ones are never made dense. Rays are followed in double, as on the processor.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "gl/gpu_device.hpp"
#include "render/renderer.hpp"

namespace isoextract::render {

struct GpuRenderOptions {
  gl::DeviceChoice device;
  std::optional<std::uint64_t> memory_bytes;  // what volume, surfaces and picture may take on the device together;
                                              // default: three quarters of what it has; no limit where it does not tell
  std::uint64_t list_bytes = 256 << 20;  // of these, what fragments of see-through surfaces may take, 8 bytes each: a
                                         // part of the picture that has more is drawn in smaller ones
  bool debug = false;                    // ErrorCode::unavailable for whatever the driver complains about; for tests

  friend bool operator==(const GpuRenderOptions&, const GpuRenderOptions&) = default;
};

struct GpuRendererAndDevice {
  std::unique_ptr<Renderer> renderer;
  gl::GpuDevice device;
};

// Opens the device. Fails with ErrorCode::unavailable where there is none. The renderer is used and dropped on this
// thread. It refuses, with ErrorCode::unavailable, what does not fit onto the device: bricks that are seen, triangles,
// or one pixel's see-through fragments. Memory of devices that draw on the processor is the context's as well.
[[nodiscard]] Result<GpuRendererAndDevice> make_gpu_renderer(const GpuRenderOptions& options);

}  // namespace isoextract::render
