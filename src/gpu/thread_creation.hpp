// Measures the cost of starting one geometry shader a cell in three ways: with the tessellator, with a buffer of dummy
// vertices, and by vertex number alone. Timokhin and Mikhaylyuk (2020) compare the first two for grids up to 2000^3:
// the tessellator is 5 times faster and takes 8 times less memory.
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
  double median_seconds = 0;  // of a pass whose threads do nothing
  double min_seconds = 0;
  double max_seconds = 0;
  std::uint64_t buffer_bytes = 0;             // size of the vertex data that only serve to make threads
  std::optional<std::uint64_t> driver_bytes;  // loss of free device memory, if the driver reports it
  std::optional<std::string> problem;         // reason if there are no figures
};

struct ThreadCreationLevel {
  int size = 0;  // the grid has size^3 cells
  std::vector<ThreadCreation> makers;
};

struct ThreadCreationResult {
  gl::GpuDevice device;
  double copy_bytes_per_second = 0;  // of a large buffer on the device; counts reading and writing
  std::vector<ThreadCreationLevel> levels;
};

// Measures all makers for each grid size, `repeats` (at least 1) times after a warm-up. First checks that each starts
// exactly one thread a cell. Fails with ErrorCode::unavailable if there is no such device, or if it cannot copy a
// buffer. A maker that fails, for example because the grid does not fit, sets `problem` in its row.
[[nodiscard]] Result<ThreadCreationResult> measure_thread_creation(const gl::DeviceChoice& device,
                                                                   const std::vector<int>& sizes, int repeats);

[[nodiscard]] std::string_view thread_maker_name(ThreadMaker maker);  // "tessellation", "dummy vertices", ...

}  // namespace isoextract::gpu
