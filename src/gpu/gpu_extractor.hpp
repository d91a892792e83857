// The GPU backend: runs cells through the graphics pipeline and collects the triangles by transform feedback. It gives
// the same set of triangles as the CPU extractor, with positions within 2 units in the last place of the local
// coordinates.
//
// The CPU compares all samples with iso once, at memory speed, to find the bricks that the surface crosses. It uploads
// and draws only these. The GPU compares again, interpolates, and writes triangles with the integer keys of their
// edges. The GPU marks ambiguous cells of marching cubes; the CPU chooses their triangles, because near ties need more
// digits than a shader has. Then the CPU welds the vertices by key.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "extract/extractor.hpp"
#include "gl/gpu_device.hpp"

namespace isoextract::gpu {

// The GPU to use and the limit of its memory.
struct GpuChoice {
  gl::DeviceChoice device;
  std::optional<std::uint64_t> memory_bytes;  // limit for samples and captured triangles on the device together;
                                              // default: a quarter of the device memory, or 1 GiB if the driver does
                                              // not report it

  friend bool operator==(const GpuChoice&, const GpuChoice&) = default;
};

// Options that do not change the mesh.
struct GpuOptions : GpuChoice {
  bool tessellation = true;   // marching cubes: draw one patch per group of cells, from which the tessellator starts
                              // one shader thread per cell; otherwise draw one point per cell
  bool swizzle = true;        // visit cells in groups of 2x2x2
  bool keep_samples = false;  // keep dense samples that fit on the device; the next extraction uploads only bricks that
                              // are missing or changed. Useful for several iso values, or for frames of one field
  bool debug = false;         // for tests: fail with ErrorCode::unavailable if the driver reports a problem
};

struct GpuExtractorAndDevice {
  std::unique_ptr<extract::Extractor> extractor;
  gl::GpuDevice device;
};

// Opens the device. Fails with ErrorCode::unavailable if there is none, with ErrorCode::usage for a limit below 1 MiB.
// Use and destroy the extractor on the calling thread. Its extract() also fails with ErrorCode::unavailable if the
// device fails, and with ErrorCode::usage if the limit is too small for the field.
[[nodiscard]] Result<GpuExtractorAndDevice> make_gpu_extractor(const GpuOptions& options);

}  // namespace isoextract::gpu
