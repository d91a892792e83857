// The extractor that draws on a GPU and captures the triangles. Same triangles as the CPU extractor's, as a set;
// positions within 2 units in the last place of the local coordinates.
//
// The host compares all samples with iso once, at memory speed, to find the bricks that the surface passes; only those
// are uploaded and drawn. The device compares again, interpolates and writes triangles with the integer keys of their
// edges. Ambiguous cells of marching cubes come back marked and are decided on the host with the CPU's own code: near
// ties need more digits than a shader has. Then the soup is welded by key.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "extract/extractor.hpp"
#include "gl/gpu_device.hpp"

namespace isoextract::gpu {

// Which GPU, and how much of it.
struct GpuChoice {
  gl::DeviceChoice device;
  std::optional<std::uint64_t> memory_bytes;  // what samples and captured triangles may take on the device together;
                                              // default: a quarter of what it has, 1 GiB where it does not tell

  friend bool operator==(const GpuChoice&, const GpuChoice&) = default;
};

// How it is used besides: the mesh is the same.
struct GpuOptions : GpuChoice {
  bool tessellation = true;   // threads of marching cubes are made by the tessellator, else by number alone
  bool swizzle = true;        // cells in groups of 2 x 2 x 2
  bool keep_samples = false;  // dense ones that fit stay on the device, and the next extraction uploads what is not
                              // there as it is by then: for several surfaces of a field, and for its frames
  bool debug = false;         // ErrorCode::unavailable for whatever the driver complains about; for tests
};

struct GpuExtractorAndDevice {
  std::unique_ptr<extract::Extractor> extractor;
  gl::GpuDevice device;
};

// Opens the device. Fails with ErrorCode::unavailable where there is none, ErrorCode::usage for too little memory. The
// extractor is used and dropped on this thread.
[[nodiscard]] Result<GpuExtractorAndDevice> make_gpu_extractor(const GpuOptions& options);

}  // namespace isoextract::gpu
