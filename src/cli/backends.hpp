// The backends by name: which one extracts, and opening it.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "extract/extractor.hpp"
#include "gpu/gpu_extractor.hpp"
#include "measure/benchmark.hpp"

namespace isoextract::cli {

enum class Backend { cpu, gpu, automatic };

[[nodiscard]] std::string_view backend_name(Backend backend);  // "cpu", "gpu", "auto"

struct BackendChoice {
  Backend backend = Backend::cpu;
  gpu::GpuOptions gpu;
};

// A backend of `bench` or `stability`: "cpu", "gpu", or the GPU another way: "gpu:points" makes the threads of marching
// cubes by number instead of by tessellation, "gpu:rows" visits the cells of a brick row by row.
struct NamedBackend {
  std::string name;
  BackendChoice choice;
  std::optional<extract::Method> only;  // the method that it is a variant of
};

// Names separated by commas, each once. Fails with ErrorKind::usage.
[[nodiscard]] Result<std::vector<NamedBackend>> parse_backends(std::string_view text);

struct OpenedBackend {
  std::unique_ptr<extract::Extractor> extractor;
  std::string note;  // for automatic: which one it is, and why
};

// cpu cannot fail; gpu fails with ErrorKind::unavailable where there is none, and never turns into the CPU. automatic
// takes a GPU if there is one that is not software, which is never faster than the CPU backend.
[[nodiscard]] Result<OpenedBackend> open_backend(const BackendChoice& choice);

// All of a list, in its order. Fails as open_backend() does.
[[nodiscard]] Result<std::vector<measure::BenchBackend>> open_backends(const std::vector<NamedBackend>& backends);

}  // namespace isoextract::cli
