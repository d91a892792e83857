// A thread that owns a GPU: its context, programs and buffers are made there and stay for whoever extracts next, on
// whatever thread. GL calls belong to the thread that opened the context (gl/gl_context.hpp).
#pragma once

#include <memory>

#include "extract/extractor.hpp"
#include "gl/gpu_device.hpp"
#include "gpu/gpu_extractor.hpp"

namespace isoextract::gpu {

// A handle: copies and extractors share the thread, which ends with the last of them.
class DrawingThread {
 public:
  // Starts the thread and opens the device on it. Fails as make_gpu_extractor() does, and with ErrorCode::unavailable
  // where the thread cannot be started.
  [[nodiscard]] static Result<DrawingThread> start(const GpuOptions& options);

  [[nodiscard]] const gl::GpuDevice& device() const;

  // One that may be used on any thread, by several side by side. Each extraction is done on the owning thread, one
  // after another, in the caller's Context, while the caller waits; exceptions reach the caller. It may use as many of
  // oneTBB's threads as those that wait leave idle. The mesh is that of make_gpu_extractor(), bit for bit.
  [[nodiscard]] std::unique_ptr<extract::Extractor> extractor() const;

  friend bool operator==(const DrawingThread&, const DrawingThread&) = default;  // the same thread

 private:
  class Owner;
  class Proxy;
  explicit DrawingThread(std::shared_ptr<Owner> owner) : owner_(std::move(owner)) {}

  std::shared_ptr<Owner> owner_;
};

}  // namespace isoextract::gpu
