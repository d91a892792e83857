#include "cli/backends.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace isoextract::cli {
Result<std::vector<NamedBackend>> parse_backends(std::string_view text) {
  std::vector<NamedBackend> backends;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    NamedBackend backend{std::string(text.substr(begin, end - begin)), {}, {}, {}};
    backend.backend = backend.name == "cpu" ? convert::Backend::cpu : convert::Backend::gpu;
    backend.gpu.tessellation = backend.name != "gpu:points";
    if (!backend.gpu.tessellation) backend.only = extract::Method::mc;
    backend.gpu.swizzle = backend.name != "gpu:rows";
    constexpr std::array<std::string_view, 4> kNames{"cpu", "gpu", "gpu:points", "gpu:rows"};
    const bool known = std::ranges::find(kNames, backend.name) != kNames.end();
    const bool again = std::ranges::find(backends, backend.name, &NamedBackend::name) != backends.end();
    if (!known || again) {
      return fail(ErrorCode::usage, fmt::format("expected a comma-separated list of {}, each at most once, found '{}'",
                                                fmt::join(kNames, ", "), text));
    }
    backends.push_back(std::move(backend));
    begin = end + 1;
  }
  return backends;
}

Result<std::vector<bench::BenchBackend>> open_backends(const std::vector<NamedBackend>& backends) {
  std::vector<bench::BenchBackend> opened;
  for (const NamedBackend& backend : backends) {
    auto one = TRY(convert::open_backend(backend.backend, backend.gpu));
    opened.push_back({backend.name, std::move(one.extractor), backend.only});
  }
  return opened;
}

}  // namespace isoextract::cli
