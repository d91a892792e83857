#include "cli/devices_command.hpp"

#include <fmt/format.h>

#include "base/limits.hpp"
#include "batch/json_values.hpp"
#include "cli/messages.hpp"
#include "gpu/gpu_device.hpp"

namespace isoextract {
namespace {

std::string device_text(const GpuDevice& device) {
  if (device.problem) return fmt::format("{}  not usable: {}\n", device.index, device.problem->message);
  std::string text = fmt::format("{}  {}\n", device.index, device.renderer);
  text += fmt::format("   vendor  {}\n   OpenGL  {}\n", device.vendor, device.version);
  text += fmt::format("   memory  {}\n", device.memory_bytes ? format_byte_size(*device.memory_bytes) : "not told");
  if (device.cuda_index) text += fmt::format("   CUDA    {}\n", *device.cuda_index);
  if (device.software) text += "   draws on the processor: right, but never faster than --backend cpu\n";
  return text;
}

Json device_json(const GpuDevice& device) {
  Json json{{"index", device.index}, {"usable", !device.problem}};
  if (device.problem) {
    json["problem"] = device.problem->message;
    return json;
  }
  json["vendor"] = device.vendor;
  json["renderer"] = device.renderer;
  json["version"] = device.version;
  json["software"] = device.software;
  json["memory_bytes"] = device.memory_bytes ? Json(*device.memory_bytes) : Json(nullptr);
  json["cuda_index"] = device.cuda_index ? Json(*device.cuda_index) : Json(nullptr);
  return json;
}

}  // namespace

Result<void> run_devices(const DevicesFlags& flags) {
  const auto devices = list_gpu_devices();
  if (!devices) return tl::unexpected(devices.error());
  std::string text;
  Json json = Json::array();
  for (const GpuDevice& device : *devices) {
    text += device_text(device);
    json.push_back(device_json(device));
  }
  return print_to_stdout(flags.json ? json_text(json) : text);
}

}  // namespace isoextract
