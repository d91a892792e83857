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

// A backend of `bench` or `stability`: "cpu", "gpu" or a variant of the GPU backend. For marching cubes, "gpu:points"
// draws one point per cell instead of tessellating patches. "gpu:rows" visits the cells of a brick row by row.
struct NamedBackend {
  std::string name;
  convert::Backend backend = convert::Backend::cpu;
  gpu::GpuOptions gpu;
  std::optional<extract::Method> only;  // the only method that this variant affects; unset: all methods
};

// Parses names separated by commas. Fails with ErrorCode::usage if a name is unknown, empty or repeated.
[[nodiscard]] Result<std::vector<NamedBackend>> parse_backends(std::string_view text);

// Opens all backends of the list, in its order. Use and destroy GPU backends on the calling thread. Fails as
// convert::open_backend() does.
[[nodiscard]] Result<std::vector<bench::BenchBackend>> open_backends(const std::vector<NamedBackend>& backends);

}  // namespace isoextract::cli
