// The devices that EGL can draw on without a display, and the choice of one.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "base/error.hpp"

namespace isoextract::gl {

struct GpuDevice {
  int index = 0;  // in the order in which EGL lists devices
  std::string vendor;
  std::string renderer;
  std::string version;                        // of OpenGL, as the driver words it
  bool software = false;                      // the processor draws: never faster than the CPU backend
  std::optional<int> cuda_index;              // where the driver tells
  std::optional<std::uint64_t> memory_bytes;  // likewise: all of it, or what is free where only that is told
  std::optional<Error> problem;               // why it cannot be used; then only the index is sure
};

// Every device, usable or not; looking makes a context on each. Fails with ErrorCode::unavailable where EGL or OpenGL
// is not installed, or lists no device.
[[nodiscard]] Result<std::vector<GpuDevice>> list_gpu_devices();

// Which device is meant. CUDA_VISIBLE_DEVICES does not reorder EGL's devices, so CUDA's numbers are matched by what the
// driver says of each.
struct CudaIndex {
  int number;

  friend bool operator==(const CudaIndex&, const CudaIndex&) = default;
};
struct DeviceName {
  std::string part;  // of vendor and renderer, whatever the case

  friend bool operator==(const DeviceName&, const DeviceName&) = default;
};
using DeviceChoice = std::variant<std::monostate, int, CudaIndex, DeviceName>;  // monostate: the first usable one that
                                                                                // is not software, else the first

// "1", "cuda:0", or a name. Fails with ErrorCode::usage.
[[nodiscard]] Result<DeviceChoice> parse_device_choice(const std::string& text);

// The device that is meant, or ErrorCode::unavailable with the list in the message.
[[nodiscard]] Result<GpuDevice> choose_device(std::span<const GpuDevice> devices, const DeviceChoice& choice);

// "llvmpipe (LLVM 15.0.6, 256 bits)", with "cuda:0" where known.
[[nodiscard]] std::string describe(const GpuDevice& device);

}  // namespace isoextract::gl
