// Parses the names of backends for `bench` and `stability`, and opens them.
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

// A backend of `bench` or `stability`: "cpu", "gpu" or a variant of the GPU backend. "gpu:points" creates the threads
// of marching cubes as points instead of by tessellation; "gpu:rows" visits the cells of a brick row by row.
struct NamedBackend {
  std::string name;
  convert::Backend backend = convert::Backend::cpu;
  gpu::GpuOptions gpu;
  std::optional<extract::Method> only;  // the only method that this variant supports
};

// Parses names separated by commas, without repetition. Fails with ErrorCode::usage.
[[nodiscard]] Result<std::vector<NamedBackend>> parse_backends(std::string_view text);

// Opens all backends of the list, in its order. Fails as convert::open_backend() does.
[[nodiscard]] Result<std::vector<bench::BenchBackend>> open_backends(const std::vector<NamedBackend>& backends);

}  // namespace isoextract::cli
