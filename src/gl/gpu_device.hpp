// The devices that EGL can draw on without a display, and the choice of one of them.
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
  int index = 0;  // position in the list of EGL devices
  std::string vendor;
  std::string renderer;
  std::string version;                        // OpenGL version string of the driver
  bool software = false;                      // the CPU draws: never faster than the CPU backend
  std::optional<int> cuda_index;              // if the driver tells
  std::optional<std::uint64_t> memory_bytes;  // if the driver tells: total memory, or free memory if only that is known
  std::optional<Error> problem;               // reason if the device cannot be used; then only the index is valid
};

// Returns all devices, usable or not. Opens a context on each, and leaves no context current on this thread. Fails with
// ErrorCode::unavailable if EGL or OpenGL is not installed, if EGL lists no device, or if the system refuses the
// threads that drivers start.
[[nodiscard]] Result<std::vector<GpuDevice>> list_gpu_devices();

// A CUDA device number. CUDA_VISIBLE_DEVICES does not reorder EGL devices, so the number is matched with the CUDA index
// that the driver reports for each device.
struct CudaIndex {
  int number;

  friend bool operator==(const CudaIndex&, const CudaIndex&) = default;
};
struct DeviceName {
  std::string part;  // part of "VENDOR RENDERER"; case is ignored

  friend bool operator==(const DeviceName&, const DeviceName&) = default;
};
// int: GpuDevice::index. monostate: the first usable device that is not software, else the first usable one.
using DeviceChoice = std::variant<std::monostate, int, CudaIndex, DeviceName>;

// Parses "1", "cuda:0", or a name. Fails with ErrorCode::usage if `text` is empty or no number follows "cuda:".
[[nodiscard]] Result<DeviceChoice> parse_device_choice(const std::string& text);

// Returns the first usable device that fits the choice. Fails with GpuDevice::problem if only unusable devices fit,
// else with ErrorCode::unavailable and a list of the devices in the message.
[[nodiscard]] Result<GpuDevice> choose_device(std::span<const GpuDevice> devices, const DeviceChoice& choice);

// Returns the renderer, such as "llvmpipe (LLVM 15.0.6, 256 bits)", with " (cuda:0)" after it if the CUDA index is
// known. Returns "not usable" for a device with a problem.
[[nodiscard]] std::string describe(const GpuDevice& device);

}  // namespace isoextract::gl
