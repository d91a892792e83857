// What it costs to start one geometry shader a cell: by the tessellator, by a buffer of dummy vertices, and by number
// alone. Timokhin and Mikhaylyuk (2020) compare the first two for grids up to 2000^3: creation 5 times faster, memory 8
// times less.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gl/gpu_device.hpp"

namespace isoextract::gpu {

enum class ThreadMaker { tessellation, dummy_vertices, vertex_number };

struct ThreadCreation {
  ThreadMaker maker = ThreadMaker::tessellation;
  double median_seconds = 0;  // of a pass whose threads end at once
  double min_seconds = 0;
  double max_seconds = 0;
  std::uint64_t buffer_bytes = 0;             // of vertex data that exist only to make threads
  std::optional<std::uint64_t> driver_bytes;  // by how much free memory fell, where the driver tells
  std::optional<std::string> problem;         // why there are no figures
};

struct ThreadCreationLevel {
  int size = 0;  // the grid has size^3 cells
  std::vector<ThreadCreation> makers;
};

struct ThreadCreationResult {
  gl::GpuDevice device;
  double copy_bytes_per_second = 0;  // of a large buffer on the device, reading and writing both counted
  std::vector<ThreadCreationLevel> levels;
};

// Every maker is first checked to start exactly one thread a cell. Fails with ErrorCode::unavailable where there is no
// such device; a grid that does not fit is a `problem` of its row.
[[nodiscard]] Result<ThreadCreationResult> measure_thread_creation(const gl::DeviceChoice& device,
                                                                   const std::vector<int>& sizes, int repeats);

[[nodiscard]] std::string_view thread_maker_name(ThreadMaker maker);  // "tessellation", "dummy vertices", ...

}  // namespace isoextract::gpu
