#include "convert/backends.hpp"

#include <utility>

#include <fmt/format.h>

namespace isoextract::convert {
namespace {

OpenedBackend open_automatic(const gpu::GpuOptions& options) {
  auto gpu = gpu::make_gpu_extractor(options);
  if (!gpu) return {extract::make_cpu_extractor(), fmt::format("cpu, because {}", gpu.error().message)};
  if (gpu->device.software) {
    return {extract::make_cpu_extractor(),
            fmt::format("cpu, because {} draws on the processor, which is slower", gl::describe(gpu->device))};
  }
  return {std::move(gpu->extractor), fmt::format("gpu, {}", gl::describe(gpu->device))};
}

}  // namespace

Result<OpenedBackend> open_backend(Backend backend, const gpu::GpuOptions& options) {
  switch (backend) {
    case Backend::cpu: return OpenedBackend{extract::make_cpu_extractor(), ""};
    case Backend::automatic: return open_automatic(options);
    case Backend::gpu: break;
  }
  auto gpu = gpu::make_gpu_extractor(options);
  if (!gpu) return tl::unexpected(std::move(gpu.error()));
  return OpenedBackend{std::move(gpu->extractor), ""};
}

}  // namespace isoextract::convert
