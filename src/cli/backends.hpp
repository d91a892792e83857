// The backends of `bench` and `stability` by name, and opening them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "bench/benchmark.hpp"
#include "convert/backends.hpp"
#include "extract/extractor.hpp"

namespace isoextract::cli {

// A backend of `bench` or `stability`: "cpu", "gpu", or the GPU another way: "gpu:points" makes the threads of marching
// cubes by number instead of by tessellation, "gpu:rows" visits the cells of a brick row by row.
struct NamedBackend {
  std::string name;
  convert::Backend backend = convert::Backend::cpu;
  gpu::GpuOptions gpu;
  std::optional<extract::Method> only;  // the method that it is a variant of
};

// Names separated by commas, each once. Fails with ErrorCode::usage.
[[nodiscard]] Result<std::vector<NamedBackend>> parse_backends(std::string_view text);

// All of a list, in its order. Fails as convert::open_backend() does.
[[nodiscard]] Result<std::vector<bench::BenchBackend>> open_backends(const std::vector<NamedBackend>& backends);

}  // namespace isoextract::cli
