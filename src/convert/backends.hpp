// Which backend extracts, and opening it.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "base/error.hpp"
#include "base/words.hpp"
#include "extract/extractor.hpp"
#include "gpu/gpu_extractor.hpp"

namespace isoextract::convert {

enum class Backend { cpu, gpu, automatic };
constexpr auto words_of(Backend /*type*/) {
  return std::array{Word{Backend::cpu, "cpu"}, Word{Backend::gpu, "gpu"}, Word{Backend::automatic, "auto"}};
}

struct BackendChoice {
  Backend backend = Backend::cpu;
  gpu::GpuChoice gpu;

  friend bool operator==(const BackendChoice&, const BackendChoice&) = default;
};

struct OpenedBackend {
  std::unique_ptr<extract::Extractor> extractor;
  std::string reason;  // for automatic: "cpu, because ...", "gpu, NAME"; else empty
};

// cpu cannot fail; gpu fails with ErrorKind::unavailable where there is none, and never turns into the CPU. automatic
// takes a GPU if there is one that is not software, which is never faster than the CPU backend. A GPU's extractor is
// used and dropped on the thread that opened it.
[[nodiscard]] Result<OpenedBackend> open_backend(Backend backend, const gpu::GpuOptions& options);

}  // namespace isoextract::convert
