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

// cpu cannot fail; gpu fails with ErrorCode::unavailable where there is none, and never turns into the CPU. automatic
// takes a GPU if there is one that is not software, which is never faster than the CPU backend. A GPU's extractor is
// used and dropped on the thread that opened it.
[[nodiscard]] Result<OpenedBackend> open_backend(Backend backend, const gpu::GpuOptions& options);

// A device that stays open from one run to the next, for runs one after another or side by side: it is opened when the
// first asks for it, on a thread of its own (gpu/drawing_thread.hpp), and samples that the next frame needs as they are
// stay on it. Safe to use from several threads.
//
// An extraction that failed there, for whatever reason, lets go of the device: who works with it goes on with it, and
// who opens a backend afterwards has it opened anew.
class KeptBackends {
 public:
  KeptBackends();
  ~KeptBackends();
  KeptBackends(const KeptBackends&) = delete;
  KeptBackends& operator=(const KeptBackends&) = delete;

  // As open_backend() does; the extractor may be used on any thread, and outlive this. Where automatic found no GPU it
  // is not looked for again. Another choice than before is opened in its place.
  [[nodiscard]] Result<OpenedBackend> open(Backend backend, const gpu::GpuChoice& choice);

  // How often a device was opened so far.
  [[nodiscard]] int devices_opened() const;

 private:
  class Device;
  class DeviceExtractor;

  std::shared_ptr<Device> device_;
};

}  // namespace isoextract::convert
