#include "gl/gpu_device.hpp"

#include <algorithm>
#include <charconv>
#include <limits>

#include <fmt/format.h>

#include "base/ascii.hpp"

namespace isoextract::gl {
namespace {

std::optional<int> parse_index(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < 0) return std::nullopt;
  return number;
}

bool matches(const GpuDevice& device, const DeviceChoice& choice) {
  if (const auto* index = std::get_if<int>(&choice)) return device.index == *index;
  if (const auto* cuda = std::get_if<CudaIndex>(&choice)) return device.cuda_index == cuda->number;
  if (const auto* name = std::get_if<DeviceName>(&choice)) {
    return to_lower(device.vendor + " " + device.renderer).find(to_lower(name->part)) != std::string::npos;
  }
  return true;
}

std::string words(const DeviceChoice& choice) {
  if (const auto* index = std::get_if<int>(&choice)) return fmt::format("{}", *index);
  if (const auto* cuda = std::get_if<CudaIndex>(&choice)) return fmt::format("cuda:{}", cuda->number);
  if (const auto* name = std::get_if<DeviceName>(&choice)) return fmt::format("'{}'", name->part);
  return "";
}

}  // namespace

Result<DeviceChoice> parse_device_choice(const std::string& text) {
  constexpr std::string_view kCuda = "cuda:";
  if (text.empty())
    return fail(ErrorCode::usage, "expected a device number, cuda:N or a device name", {Remedy::see, Setting::devices});
  if (text.starts_with(kCuda)) {
    const auto number = parse_index(std::string_view(text).substr(kCuda.size()));
    if (!number) {
      return fail(ErrorCode::usage, fmt::format("expected a number after cuda:, found '{}'", text),
                  {Remedy::see, Setting::devices});
    }
    return CudaIndex{*number};
  }
  if (const auto index = parse_index(text)) return *index;
  return DeviceName{text};
}

Result<GpuDevice> choose_device(std::span<const GpuDevice> devices, const DeviceChoice& choice) {
  const bool any = std::holds_alternative<std::monostate>(choice);
  const GpuDevice* found = nullptr;
  const GpuDevice* broken = nullptr;
  for (const GpuDevice& device : devices) {
    if (!matches(device, choice)) continue;
    if (device.problem) {
      if (broken == nullptr) broken = &device;
      continue;
    }
    if (found == nullptr || (any && found->software && !device.software)) found = &device;
  }
  if (found != nullptr) return *found;
  if (broken != nullptr) return tl::unexpected(*broken->problem);
  std::string list;
  for (const GpuDevice& device : devices) {
    list += fmt::format("{}{}: {}", list.empty() ? "" : ", ", device.index, describe(device));
    if (device.problem) list += fmt::format(" ({})", device.problem->message);
  }
  return fail(ErrorCode::unavailable, fmt::format("there is no device {}; the devices are {}", words(choice), list),
              {{Remedy::see, Setting::devices}, {Remedy::leave_out, Setting::device, "the program then chooses one"}});
}

std::string describe(const GpuDevice& device) {
  if (device.problem) return "not usable";
  return device.cuda_index ? fmt::format("{} (cuda:{})", device.renderer, *device.cuda_index) : device.renderer;
}

}  // namespace isoextract::gl
