// What a picture takes on the device.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "gl/gpu_device.hpp"

namespace isoextract::render::detail {

// Counts up while a picture is drawn or a volume uploaded, and gives all back when it goes.
class GpuMemory {
 public:
  // `limit`: as GpuRenderOptions::memory_bytes. `besides`: what others of these have taken. Device and context outlive
  // this.
  GpuMemory(const gl::GpuDevice& device, std::optional<std::uint64_t> limit, std::uint64_t besides,
            const Context& context);

  // Before it is taken on the device; `what` completes "... for". Fails with ErrorCode::unavailable beyond the limit,
  // and as Context::reserve() where the device's memory is the program's own.
  [[nodiscard]] Result<void> take(std::uint64_t bytes, const std::string& what);

  // With what was there besides.
  [[nodiscard]] std::uint64_t taken() const { return taken_; }

 private:
  const gl::GpuDevice& device_;
  const Context& context_;
  std::optional<std::uint64_t> limit_;
  bool is_told_;  // the limit was asked for
  std::uint64_t taken_;
  Reservation memory_;
};

}  // namespace isoextract::render::detail
