// Counts the device memory of a picture.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "gl/gpu_device.hpp"

namespace isoextract::render::detail {

// Counts allocations while a picture is drawn or a volume uploaded. Its destructor releases the reservations.
class GpuMemory {
 public:
  // `limit` is GpuRenderOptions::memory_bytes. `besides` is the number of bytes that other counters have taken.
  // `device` and `context` must outlive this object.
  GpuMemory(const gl::GpuDevice& device, std::optional<std::uint64_t> limit, std::uint64_t besides,
            const Context& context);

  // Call before allocating on the device; `what` names the data in messages. Fails with ErrorCode::unavailable beyond
  // the limit, and as Context::reserve() does if the device renders in software.
  [[nodiscard]] Result<void> take(std::uint64_t bytes, const std::string& what);

  // Returns the bytes taken, including `besides`.
  [[nodiscard]] std::uint64_t taken() const { return taken_; }

 private:
  const gl::GpuDevice& device_;
  const Context& context_;
  std::optional<std::uint64_t> limit_;
  bool is_told_;  // the user set the limit
  std::uint64_t taken_;
  Reservation memory_;
};

}  // namespace isoextract::render::detail
