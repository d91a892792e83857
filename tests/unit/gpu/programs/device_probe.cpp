// Opens a device in a process of its own and prints the result in one line, for device_test.cpp.
#include <cstdio>

#include "gpu/gpu_extractor.hpp"

int main() {
  const auto extractor = isoextract::gpu::make_gpu_extractor({});
  if (extractor) {
    std::printf("drawing on %s\n", extractor->extractor->device().c_str());
    return 0;
  }
  const isoextract::Error& error = extractor.error();
  std::printf("error %d|%s", exit_code_of(error.code), error.message.c_str());
  for (const isoextract::Step& step : error.hint.steps) {
    std::printf("|%s", step.setting == isoextract::Setting::cpu_backend ? "use_cpu" : step.text.c_str());
  }
  std::printf("\n");
  // An unusable device is listed, too, and must be marked as such.
  const auto devices = isoextract::gl::list_gpu_devices();
  if (!devices) return 0;
  for (const isoextract::gl::GpuDevice& device : *devices) {
    if (!device.problem) return 1;
  }
  return 0;
}
