// A thread that owns a GPU context. GL calls must come from the thread that opened the context (gl/gl_context.hpp).
// This thread makes the context, programs and buffers, and keeps them for later extractions that any thread requests.
#pragma once

#include <memory>

#include "extract/extractor.hpp"
#include "gl/gpu_device.hpp"
#include "gpu/gpu_extractor.hpp"

namespace isoextract::gpu {

// A handle. Copies and extractors share the thread, which ends with the last of them.
class DrawingThread {
 public:
  // Starts the thread and opens the device on it. Fails as make_gpu_extractor() does, and with ErrorCode::unavailable
  // if the thread cannot be started.
  [[nodiscard]] static Result<DrawingThread> start(const GpuOptions& options);

  [[nodiscard]] const gl::GpuDevice& device() const;

  // Returns an extractor that any thread may use, several at once. The owning thread does the extractions one after
  // another in the caller's Context while the caller waits. Exceptions reach the caller. An extraction may use as many
  // oneTBB threads as the waiting callers leave idle. The mesh equals a mesh of make_gpu_extractor() bit for bit.
  [[nodiscard]] std::unique_ptr<extract::Extractor> extractor() const;

  friend bool operator==(const DrawingThread&, const DrawingThread&) = default;  // true for handles of the same thread

 private:
  class Owner;
  class Proxy;
  explicit DrawingThread(std::shared_ptr<Owner> owner) : owner_(std::move(owner)) {}

  std::shared_ptr<Owner> owner_;
};

}  // namespace isoextract::gpu
