// An OpenGL context without display and surface (EGL device platform), and its error reports.
//
// list_gpu_devices() (gpu_device.hpp) opens and closes contexts, and leaves none current.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "gl/gpu_device.hpp"

namespace isoextract::gl {

class HeadlessContext;

struct ContextOptions {
  DeviceChoice device;
  bool debug = false;  // for tests: collect the messages of the driver (KHR_debug)
};

// open() makes the context current. The context belongs to the thread that opened it: GL calls are allowed on that
// thread only, while the object exists. A framebuffer without attachments is bound, because without one every draw
// fails. A vertex array is bound, GL_RASTERIZER_DISCARD is on, rows of uploads are not padded, and patches have one
// vertex.
class GlContext {
 public:
  // Opens a context with core profile 4.3 or newer. Fails with ErrorCode::unavailable.
  [[nodiscard]] static Result<std::unique_ptr<GlContext>> open(const ContextOptions& options);

  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;
  ~GlContext();

  [[nodiscard]] const GpuDevice& device() const { return device_; }

  // Makes this context current. Needed if this thread has since opened another one. Fails with ErrorCode::unavailable
  // if EGL refuses.
  Result<void> make_current() const;

  // Fails with ErrorCode::unavailable and a hint if GL has reported an error since the last call, or if the driver has
  // reset the GPU. `doing` completes "while ..." in the message. The context must be current.
  [[nodiscard]] Result<void> check(const std::string& doing) const;

  // Returns the driver's messages since the context was opened: errors, undefined behavior and severe messages, without
  // performance hints. Empty without `debug`.
  [[nodiscard]] const std::vector<std::string>& debug_messages() const;

 private:
  GlContext(std::unique_ptr<HeadlessContext> context, GpuDevice device);
  [[nodiscard]] Error lost(std::string_view why, const std::string& doing) const;

  std::unique_ptr<HeadlessContext> context_;
  GpuDevice device_;
};

}  // namespace isoextract::gl
