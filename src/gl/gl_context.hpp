// A current OpenGL context without display and surface (EGL device platform), and what went wrong in it.
//
// list_gpu_devices() (gpu_device.hpp) opens and closes contexts: it leaves none current.
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
  bool debug = false;  // collect the driver's own messages (KHR_debug), for tests
};

// Belongs to the thread that opened it: GL calls on that thread only, and none when it is gone. Current once opened. A
// framebuffer without attachments is bound, because without one every draw fails.
class GlContext {
 public:
  // Core profile 4.3 or newer. Fails with ErrorCode::unavailable.
  [[nodiscard]] static Result<std::unique_ptr<GlContext>> open(const ContextOptions& options);

  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;
  ~GlContext();

  [[nodiscard]] const GpuDevice& device() const { return device_; }

  // For threads with several contexts: GL calls go to the one that was made current last. Fails with
  // ErrorCode::unavailable where the context was lost.
  Result<void> make_current() const;

  // What GL has to say since the last call, as a sentence: out of memory and a lost context are
  // ErrorCode::unavailable with the option that helps. `doing` completes "while ...".
  [[nodiscard]] Result<void> check(const std::string& doing) const;

  // Errors, undefined behaviour and what is severe, but no hints about speed, since the context was opened. Only with
  // `debug`.
  [[nodiscard]] const std::vector<std::string>& debug_messages() const;

 private:
  GlContext(std::unique_ptr<HeadlessContext> context, GpuDevice device);
  [[nodiscard]] Error lost(std::string_view why, const std::string& doing) const;

  std::unique_ptr<HeadlessContext> context_;
  GpuDevice device_;
};

}  // namespace isoextract::gl
