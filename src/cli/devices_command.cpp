// `isoextract devices`: lists the devices for the GPU backend.
#include <fmt/format.h>

#include "base/byte_size.hpp"
#include "cli/command.hpp"
#include "cli/messages.hpp"
#include "cli/options/run.hpp"
#include "convert/json_documents.hpp"
#include "convert/json_values.hpp"
#include "gl/gpu_device.hpp"

namespace isoextract::cli {
namespace {

struct DevicesFlags : OptionSet {
  JsonFlag json{in(OptionGroup::output), "Report as JSON, an array with one entry a device."};
  RunFlags run{*this, RunFlags::Taken::quiet};  // prints only its results
};

std::string device_text(const gl::GpuDevice& device) {
  if (device.problem) return fmt::format("{}  not usable: {}\n", device.index, device.problem->message);
  std::string text = fmt::format("{}  {}\n", device.index, device.renderer);
  text += fmt::format("   vendor  {}\n   OpenGL  {}\n", device.vendor, device.version);
  text += fmt::format("   memory  {}\n", device.memory_bytes ? format_byte_size(*device.memory_bytes) : "unknown");
  if (device.cuda_index) text += fmt::format("   CUDA    {}\n", *device.cuda_index);
  if (device.software) text += "   renders in software on the CPU: correct, but never faster than --backend cpu\n";
  return text;
}

convert::Json device_json(const gl::GpuDevice& device) {
  convert::Json json{
      {"schema", word_of(convert::JsonDocument::devices)}, {"index", device.index}, {"usable", !device.problem}};
  if (device.problem) {
    json["problem"] = device.problem->message;
    return json;
  }
  json["vendor"] = device.vendor;
  json["renderer"] = device.renderer;
  json["version"] = device.version;
  json["software"] = device.software;
  json["memory_bytes"] = device.memory_bytes ? convert::Json(*device.memory_bytes) : convert::Json(nullptr);
  json["cuda_index"] = device.cuda_index ? convert::Json(*device.cuda_index) : convert::Json(nullptr);
  return json;
}

class DevicesCommand final : public CommandOf<DevicesFlags> {
 public:
  DevicesCommand() : CommandOf({"devices", "[options]", "List the GPUs that work without a display."}) {}

  // Lists unusable devices with the reason. Fails with ErrorCode::unavailable if there is no device at all.
  Result<int> run(const std::vector<std::string>& /*arguments*/) override {
    const auto devices = TRY(gl::list_gpu_devices());
    std::string text;
    convert::Json json = convert::Json::array();
    for (const gl::GpuDevice& device : devices) {
      text += device_text(device);
      json.push_back(device_json(device));
    }
    TRY(print_to_stdout(flags().json ? convert::json_text(json) : text));
    return kDone;
  }
};

}  // namespace

std::unique_ptr<Command> make_devices_command() { return std::make_unique<DevicesCommand>(); }

}  // namespace isoextract::cli
