#include "cli/backends.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace isoextract::cli {
namespace {

OpenedBackend open_automatic(const gpu::GpuOptions& options) {
  auto gpu = gpu::make_gpu_extractor(options);
  if (!gpu) return {extract::make_cpu_extractor(), fmt::format("--backend auto: cpu, because {}", gpu.error().message)};
  if (gpu->device.software) {
    return {
        extract::make_cpu_extractor(),
        fmt::format("--backend auto: cpu, because {} draws on the processor, which is slower", describe(gpu->device))};
  }
  return {std::move(gpu->extractor), fmt::format("--backend auto: gpu, {}", describe(gpu->device))};
}

}  // namespace

std::string_view backend_name(Backend backend) {
  switch (backend) {
    case Backend::cpu: return "cpu";
    case Backend::gpu: return "gpu";
    case Backend::automatic: break;
  }
  return "auto";
}

Result<std::vector<NamedBackend>> parse_backends(std::string_view text) {
  std::vector<NamedBackend> backends;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    NamedBackend backend{std::string(text.substr(begin, end - begin)), {}, {}};
    backend.choice.backend = backend.name == "cpu" ? Backend::cpu : Backend::gpu;
    backend.choice.gpu.tessellation = backend.name != "gpu:points";
    if (!backend.choice.gpu.tessellation) backend.only = extract::Method::mc;
    backend.choice.gpu.swizzle = backend.name != "gpu:rows";
    constexpr std::array<std::string_view, 4> kNames{"cpu", "gpu", "gpu:points", "gpu:rows"};
    const bool known = std::ranges::find(kNames, backend.name) != kNames.end();
    const bool again = std::ranges::find(backends, backend.name, &NamedBackend::name) != backends.end();
    if (!known || again) {
      return fail(ErrorKind::usage,
                  fmt::format("expected some of {}, each once, found '{}'", fmt::join(kNames, ", "), text));
    }
    backends.push_back(std::move(backend));
    begin = end + 1;
  }
  return backends;
}

Result<OpenedBackend> open_backend(const BackendChoice& choice) {
  switch (choice.backend) {
    case Backend::cpu: return OpenedBackend{extract::make_cpu_extractor(), ""};
    case Backend::automatic: return open_automatic(choice.gpu);
    case Backend::gpu: break;
  }
  auto gpu = gpu::make_gpu_extractor(choice.gpu);
  if (!gpu) return tl::unexpected(gpu.error());
  return OpenedBackend{std::move(gpu->extractor), ""};
}

Result<std::vector<measure::BenchBackend>> open_backends(const std::vector<NamedBackend>& backends) {
  std::vector<measure::BenchBackend> opened;
  for (const NamedBackend& backend : backends) {
    auto one = open_backend(backend.choice);
    if (!one) return tl::unexpected(one.error());
    opened.push_back({backend.name, std::move(one->extractor), backend.only});
  }
  return opened;
}

}  // namespace isoextract::cli
