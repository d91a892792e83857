#include "convert/backends.hpp"

#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "gpu/drawing_thread.hpp"

namespace isoextract::convert {
namespace {

OpenedBackend cpu_because(const std::string& why) {
  return {extract::make_cpu_extractor(), fmt::format("cpu, because {}", why)};
}

std::string software_reason(const gl::GpuDevice& device) {
  return fmt::format("{} renders on the CPU, which is slower", gl::describe(device));
}

OpenedBackend open_automatic(const gpu::GpuOptions& options) {
  auto gpu = gpu::make_gpu_extractor(options);
  if (!gpu) return cpu_because(gpu.error().message);
  if (gpu->device.software) return cpu_because(software_reason(gpu->device));
  return {std::move(gpu->extractor), fmt::format("gpu, {}", gl::describe(gpu->device))};
}

}  // namespace

Result<OpenedBackend> open_backend(Backend backend, const gpu::GpuOptions& options) {
  switch (backend) {
    case Backend::cpu: return OpenedBackend{extract::make_cpu_extractor(), ""};
    case Backend::automatic: return open_automatic(options);
    case Backend::gpu: break;
  }
  auto gpu = TRY(gpu::make_gpu_extractor(options));
  return OpenedBackend{std::move(gpu.extractor), ""};
}

// The device that is open now, if any.
class BackendCache::Device {
 public:
  // Opens the device if it is not open. Other callers wait, so that only one device is opened.
  Result<gpu::DrawingThread> open(const gpu::GpuChoice& choice) {
    const std::lock_guard lock(mutex_);
    return open_locked(choice);
  }

  // Returns nullopt for the CPU; `reason` then says why, and otherwise names the device.
  std::optional<gpu::DrawingThread> open_automatic(const gpu::GpuChoice& choice, std::string& reason) {
    const std::lock_guard lock(mutex_);
    if (!no_gpu_ || choice != choice_) {
      const auto opened = open_locked(choice);
      if (opened && !opened->device().software) {
        reason = fmt::format("gpu, {}", gl::describe(opened->device()));
        return *opened;
      }
      no_gpu_ = opened ? software_reason(opened->device()) : opened.error().message;
      thread_.reset();
    }
    reason = *no_gpu_;
    return std::nullopt;
  }

  void let_go(const gpu::DrawingThread& thread) {
    const std::lock_guard lock(mutex_);
    if (thread_ == thread) thread_.reset();
  }

  [[nodiscard]] int opened() const {
    const std::lock_guard lock(mutex_);
    return opened_;
  }

 private:
  Result<gpu::DrawingThread> open_locked(const gpu::GpuChoice& choice) {
    if (thread_ && choice == choice_) return *thread_;
    thread_.reset();
    no_gpu_.reset();
    choice_ = choice;
    gpu::GpuOptions options{choice};
    options.keep_samples = true;
    auto started = gpu::DrawingThread::start(options);
    if (!started) return started;
    ++opened_;
    thread_ = *started;
    return started;
  }

  mutable std::mutex mutex_;
  gpu::GpuChoice choice_;
  std::optional<gpu::DrawingThread> thread_;
  std::optional<std::string> no_gpu_;  // why automatic takes the CPU
  int opened_ = 0;
};

// A failed extraction leaves the device in an unknown state, so the next conversion opens it anew.
class BackendCache::DeviceExtractor final : public extract::Extractor {
 public:
  DeviceExtractor(std::shared_ptr<Device> device, gpu::DrawingThread thread)
      : device_(std::move(device)), thread_(std::move(thread)), extractor_(thread_.extractor()) {}

  [[nodiscard]] std::string_view name() const override { return extractor_->name(); }
  [[nodiscard]] std::string device() const override { return extractor_->device(); }
  [[nodiscard]] bool has(extract::Method method) const override { return extractor_->has(method); }

 private:
  [[nodiscard]] Result<extract::Extraction> run(const field::ScalarField& field, const extract::ExtractOptions& options,
                                                const Context& context) override {
    try {
      auto extraction = extractor_->extract(field, options, context);
      if (!extraction) device_->let_go(thread_);
      return extraction;
    } catch (...) {
      device_->let_go(thread_);
      throw;
    }
  }

  std::shared_ptr<Device> device_;
  gpu::DrawingThread thread_;
  std::unique_ptr<extract::Extractor> extractor_;
};

BackendCache::BackendCache() : device_(std::make_shared<Device>()) {}
BackendCache::~BackendCache() = default;

Result<OpenedBackend> BackendCache::open(Backend backend, const gpu::GpuChoice& choice) {
  if (backend == Backend::cpu) return open_backend(backend, {choice});
  if (backend == Backend::automatic) {
    std::string reason;
    const auto thread = device_->open_automatic(choice, reason);
    if (!thread) return cpu_because(reason);
    return OpenedBackend{std::make_unique<DeviceExtractor>(device_, *thread), reason};
  }
  auto thread = TRY(device_->open(choice));
  return OpenedBackend{std::make_unique<DeviceExtractor>(device_, std::move(thread)), ""};
}

int BackendCache::devices_opened() const { return device_->opened(); }

}  // namespace isoextract::convert
