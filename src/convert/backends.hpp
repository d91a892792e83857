// Choosing and opening the backend (CPU or GPU) that extracts.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "base/enum_words.hpp"
#include "base/error.hpp"
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
  std::string reason;  // for Backend::automatic: "cpu, because ...", "gpu, NAME"; else empty
};

// Opens a backend. cpu never fails. gpu fails as gpu::make_gpu_extractor() does, and never falls back to the CPU.
// automatic takes a GPU if a hardware GPU opens, else the CPU, and so never fails. It takes no software GPU, which is
// slower than the CPU backend. Use and destroy a GPU's extractor on the thread that opened it.
[[nodiscard]] Result<OpenedBackend> open_backend(Backend backend, const gpu::GpuOptions& options);

// Keeps one GPU device open from one conversion to the next, whether they run in turn or side by side. The first caller
// opens it, on a thread of its own (gpu/drawing_thread.hpp). Samples that the next frame needs unchanged stay on the
// device. Safe to use from several threads.
//
// After any failed extraction the device is dropped, because its state is unknown. Extractors already opened keep using
// it; the next open() opens the device anew.
class BackendCache {
 public:
  BackendCache();
  ~BackendCache();
  BackendCache(const BackendCache&) = delete;
  BackendCache& operator=(const BackendCache&) = delete;

  // Opens a backend as open_backend() does, but the extractor may be used on any thread and may outlive this object. If
  // automatic found no hardware GPU, the next automatic call with the same choice does not search again, unless a call
  // for gpu came between. A call for a GPU with another choice opens another device in place of the kept one.
  [[nodiscard]] Result<OpenedBackend> open(Backend backend, const gpu::GpuChoice& choice);

  // Returns how many times a device was opened so far.
  [[nodiscard]] int devices_opened() const;

 private:
  class Device;
  class DeviceExtractor;

  std::shared_ptr<Device> device_;
};

}  // namespace isoextract::convert
