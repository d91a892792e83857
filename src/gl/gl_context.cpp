#include "gl/gl_context.hpp"

#include <dlfcn.h>
#include <epoxy/gl.h>
// The EGL header of epoxy, because EGL/egl.h defines KHRONOS_FALSE differently from epoxy/gl.h.
#include <epoxy/egl.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "base/machine.hpp"

namespace isoextract::gl {
namespace {

constexpr int kMajor = 4;
constexpr int kMinor = 3;

tl::unexpected<Error> unavailable(std::string message, Hint hint = {Remedy::use, Setting::cpu_backend}) {
  return fail(ErrorCode::unavailable, std::move(message), std::move(hint));
}

std::string_view egl_error_words(EGLint code) {
  switch (code) {
    case EGL_SUCCESS: return "EGL reports no reason";
    case EGL_NOT_INITIALIZED: return "the driver failed to initialize";
    case EGL_BAD_ACCESS: return "the driver denied access";
    case EGL_BAD_ALLOC: return "not enough memory";
    case EGL_BAD_ATTRIBUTE: return "the driver does not know an attribute";
    case EGL_BAD_CONFIG: return "the driver has no such configuration";
    case EGL_BAD_CONTEXT: return "the context is not valid";
    case EGL_BAD_DISPLAY: return "the display is not valid";
    case EGL_BAD_MATCH: return "the driver does not offer this version of OpenGL";
    case EGL_BAD_PARAMETER: return "a parameter is not valid";
    case EGL_CONTEXT_LOST: return "the driver lost the context";
    default: return "an unknown reason";
  }
}

std::string egl_reason() {
  const EGLint code = eglGetError();
  return fmt::format("{} (EGL error 0x{:04X})", egl_error_words(code), code);
}

// epoxy ends the program if a library is missing or unusable, so this checks first. The handles stay open until the
// process ends.
Result<void> load_libraries() {
  struct Library {
    std::array<const char*, 2> names;
    const char* function;
    std::string_view what, package;
  };
  constexpr std::array<Library, 2> kLibraries{{
      {{"libEGL.so.1", nullptr}, "eglGetProcAddress", "EGL", "libegl1"},
      {{"libOpenGL.so.0", "libGL.so.1"}, "glGetString", "OpenGL", "libopengl0 or libgl1"},
  }};
  for (const Library& library : kLibraries) {
    std::string why;
    const bool found = std::ranges::any_of(library.names, [&](const char* name) {
      if (name == nullptr) return false;
      void* handle = ::dlopen(name, RTLD_NOW | RTLD_GLOBAL);
      if (handle != nullptr && ::dlsym(handle, library.function) != nullptr) return true;
      if (why.empty()) why = ::dlerror();
      return false;
    });
    if (found) continue;
    return unavailable(fmt::format("this machine has no GPU backend: {} failed to load ({})", library.what, why),
                       {fmt::format("on Debian install {}", library.package), {Remedy::use, Setting::cpu_backend}});
  }
  return {};
}

bool has_client_extension(const char* name) { return epoxy_has_egl_extension(EGL_NO_DISPLAY, name); }

// Fails unless as many threads can start as the machine has cores. Drivers start threads of their own (software drivers
// one a core), and wait forever if they cannot.
Result<void> check_threads() {
  const StartableThreads started =
      start_threads_together(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
  if (started.refusal.empty()) return {};
  return unavailable(fmt::format("GPU drivers start their own threads, and the system allows no more than {}: {}",
                                 started.count, started.refusal),
                     {"raise the limit (ulimit -u)", {Remedy::use, Setting::cpu_backend}});
}

Result<std::vector<EGLDeviceEXT>> egl_devices() {
  TRY(check_threads());
  TRY(load_libraries());
  if (!has_client_extension("EGL_EXT_platform_base") ||
      !(has_client_extension("EGL_EXT_device_enumeration") || has_client_extension("EGL_EXT_device_base"))) {
    return unavailable(
        "EGL cannot list devices here (EGL_EXT_device_enumeration): no driver for headless drawing is installed",
        {"on Debian install libegl-mesa0, or the GPU's own driver", {Remedy::use, Setting::cpu_backend}});
  }
  EGLint count = 0;
  if (eglQueryDevicesEXT(0, nullptr, &count) == EGL_FALSE) {
    return unavailable(fmt::format("EGL could not list its devices: {}", egl_reason()));
  }
  std::vector<EGLDeviceEXT> devices(static_cast<std::size_t>(count));
  if (count > 0 && eglQueryDevicesEXT(count, devices.data(), &count) == EGL_FALSE) {
    return unavailable(fmt::format("EGL could not list its devices: {}", egl_reason()));
  }
  devices.resize(static_cast<std::size_t>(count));
  if (devices.empty()) return unavailable("EGL lists no device");
  return devices;
}

std::string gl_text(GLenum name) {
  const GLubyte* text = glGetString(name);
  return text == nullptr ? "" : reinterpret_cast<const char*>(text);
}

bool is_software(std::string_view renderer) {
  constexpr std::array<std::string_view, 4> kNames{"llvmpipe", "softpipe", "swrast", "SWR"};
  return std::ranges::any_of(kNames,
                             [&](std::string_view name) { return renderer.find(name) != std::string_view::npos; });
}

std::optional<std::uint64_t> device_memory(bool software) {
  if (software) return std::nullopt;
  GLint kilobytes[4] = {};
  if (epoxy_has_gl_extension("GL_NVX_gpu_memory_info")) {
    glGetIntegerv(GL_GPU_MEMORY_INFO_TOTAL_AVAILABLE_MEMORY_NVX, kilobytes);
  } else if (epoxy_has_gl_extension("GL_ATI_meminfo")) {
    glGetIntegerv(GL_TEXTURE_FREE_MEMORY_ATI, kilobytes);
  }
  if (kilobytes[0] <= 0) return std::nullopt;
  return std::uint64_t{1024} * static_cast<std::uint64_t>(kilobytes[0]);
}

std::string_view gl_error_words(GLenum code) {
  switch (code) {
    case GL_INVALID_ENUM: return "the driver does not know a value";
    case GL_INVALID_VALUE: return "a number is out of range";
    case GL_INVALID_OPERATION: return "the driver does not allow the operation in its present state";
    case GL_INVALID_FRAMEBUFFER_OPERATION: return "the framebuffer is not complete";
    case GL_STACK_OVERFLOW: return "a stack is full";
    case GL_STACK_UNDERFLOW: return "a stack is empty";
    default: return "an unknown reason";
  }
}

std::string_view reset_text(GLenum status) {
  switch (status) {
    case GL_GUILTY_CONTEXT_RESET: return "because of this program";
    case GL_INNOCENT_CONTEXT_RESET: return "because of another program";
    default: return "for an unknown reason";
  }
}

void GLAPIENTRY on_debug_message(GLenum, GLenum type, GLuint, GLenum severity, GLsizei length, const GLchar* text,
                                 const void* list) {
  // Performance and memory hints come at every severity; ignore them.
  const bool counts = type == GL_DEBUG_TYPE_ERROR || type == GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR ||
                      (severity == GL_DEBUG_SEVERITY_HIGH && type != GL_DEBUG_TYPE_PERFORMANCE);
  if (!counts) return;
  auto* messages = static_cast<std::vector<std::string>*>(const_cast<void*>(list));
  messages->emplace_back(text, static_cast<std::size_t>(length));
}

}  // namespace

// Owns the context; makes it current when opened.
class HeadlessContext {
 public:
  HeadlessContext() = default;
  HeadlessContext(const HeadlessContext&) = delete;
  HeadlessContext& operator=(const HeadlessContext&) = delete;

  ~HeadlessContext() {
    if (context_ != EGL_NO_CONTEXT) {
      make_current();
      if (framebuffer_ != 0) glDeleteFramebuffers(1, &framebuffer_);
      if (vertex_array_ != 0) glDeleteVertexArrays(1, &vertex_array_);
      eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
      eglDestroyContext(display_, context_);
    }
    // All contexts of the process on this device share the display, so it is not terminated here.
  }

  // Creates a context on a device and makes it current.
  Result<void> open(EGLDeviceEXT device, bool debug) {
    display_ = eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, nullptr);
    if (display_ == EGL_NO_DISPLAY)
      return unavailable(fmt::format("EGL gave no display for the device: {}", egl_reason()));
    EGLint major = 0;
    EGLint minor = 0;
    if (eglInitialize(display_, &major, &minor) == EGL_FALSE) {
      return unavailable(fmt::format("EGL failed to initialize on the device: {}", egl_reason()));
    }
    if (!epoxy_has_egl_extension(display_, "EGL_KHR_no_config_context") ||
        !epoxy_has_egl_extension(display_, "EGL_KHR_surfaceless_context")) {
      return unavailable("the driver cannot draw without a window surface (EGL_KHR_surfaceless_context)");
    }
    if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) {
      return unavailable(fmt::format("the driver has no OpenGL: {}", egl_reason()));
    }
    if (!create(true, debug) && !create(false, debug)) {
      return unavailable(
          fmt::format("the driver created no OpenGL {}.{} core context: {}", kMajor, kMinor, egl_reason()));
    }
    TRY(make_current());
    if (epoxy_gl_version() < 10 * kMajor + kMinor) {
      return unavailable(fmt::format("expected OpenGL {}.{} or newer, found {}", kMajor, kMinor, gl_text(GL_VERSION)));
    }
    set_up(debug);
    return {};
  }

  Result<void> make_current() const {
    if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE) return {};
    return unavailable(fmt::format("EGL failed to make the OpenGL context current: {}", egl_reason()));
  }

  [[nodiscard]] bool reports_resets() const { return reports_resets_; }
  [[nodiscard]] const std::vector<std::string>& messages() const { return messages_; }

 private:
  bool create(bool robust, bool debug) {
    std::vector<EGLint> attributes{EGL_CONTEXT_MAJOR_VERSION,       kMajor,
                                   EGL_CONTEXT_MINOR_VERSION,       kMinor,
                                   EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                   EGL_CONTEXT_OPENGL_DEBUG,        debug ? EGL_TRUE : EGL_FALSE};
    if (robust) {
      attributes.insert(attributes.end(), {EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_LOSE_CONTEXT_ON_RESET});
    }
    attributes.push_back(EGL_NONE);
    context_ = eglCreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
    reports_resets_ = robust && context_ != EGL_NO_CONTEXT;
    return context_ != EGL_NO_CONTEXT;
  }

  void set_up(bool debug) {
    if (debug) {
      glEnable(GL_DEBUG_OUTPUT);
      glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
      glDebugMessageCallback(on_debug_message, &messages_);
    }
    reports_resets_ = reports_resets_ && (epoxy_gl_version() >= 45 || epoxy_has_gl_extension("GL_KHR_robustness"));
    glGenFramebuffers(1, &framebuffer_);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    glFramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_WIDTH, 1);
    glFramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_HEIGHT, 1);
    glGenVertexArrays(1, &vertex_array_);
    glBindVertexArray(vertex_array_);
    glEnable(GL_RASTERIZER_DISCARD);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glPatchParameteri(GL_PATCH_VERTICES, 1);
  }

  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  GLuint framebuffer_ = 0;
  GLuint vertex_array_ = 0;
  bool reports_resets_ = false;
  std::vector<std::string> messages_;
};

namespace {

GpuDevice describe_current(int index, EGLDeviceEXT egl_device) {
  GpuDevice device;
  device.index = index;
  device.vendor = gl_text(GL_VENDOR);
  device.renderer = gl_text(GL_RENDERER);
  device.version = gl_text(GL_VERSION);
  device.software = is_software(device.renderer);
  device.memory_bytes = device_memory(device.software);
  const char* extensions = eglQueryDeviceStringEXT(egl_device, EGL_EXTENSIONS);
  EGLAttrib cuda = 0;
  if (extensions != nullptr && std::string_view(extensions).find("EGL_NV_device_cuda") != std::string_view::npos &&
      eglQueryDeviceAttribEXT(egl_device, EGL_CUDA_DEVICE_NV, &cuda) == EGL_TRUE) {
    device.cuda_index = static_cast<int>(cuda);
  }
  return device;
}

// A context on a device with its description, or the reason why there is none.
struct OpenedDevice {
  GpuDevice device;
  std::unique_ptr<HeadlessContext> context;
};

OpenedDevice open_device(const std::vector<EGLDeviceEXT>& devices, int index, bool debug) {
  OpenedDevice opened;
  const EGLDeviceEXT device = devices[static_cast<std::size_t>(index)];
  auto context = std::make_unique<HeadlessContext>();
  if (auto done = context->open(device, debug); !done) {
    opened.device.index = index;
    opened.device.problem = done.error();
    return opened;
  }
  opened.device = describe_current(index, device);
  opened.context = std::move(context);
  return opened;
}

}  // namespace

GlContext::GlContext(std::unique_ptr<HeadlessContext> context, GpuDevice device)
    : context_(std::move(context)), device_(std::move(device)) {}

GlContext::~GlContext() = default;

Result<void> GlContext::make_current() const { return context_->make_current(); }

Result<std::unique_ptr<GlContext>> GlContext::open(const ContextOptions& options) {
  const auto egl = TRY(egl_devices());
  // Opening is slow on machines with many GPUs, so the search stops at the first suitable device.
  const auto* index = std::get_if<int>(&options.device);
  std::vector<GpuDevice> seen;
  for (int d = 0; d < static_cast<int>(egl.size()); ++d) {
    if (index != nullptr && *index != d && *index < static_cast<int>(egl.size())) continue;
    OpenedDevice opened = open_device(egl, d, options.debug);
    seen.push_back(opened.device);
    const bool fits = choose_device({&opened.device, 1}, options.device).has_value();
    const bool better_may_come = std::holds_alternative<std::monostate>(options.device) && opened.device.software &&
                                 d + 1 < static_cast<int>(egl.size());
    if (fits && !better_may_come) {
      return std::unique_ptr<GlContext>(new GlContext(std::move(opened.context), std::move(opened.device)));
    }
  }
  const auto chosen = TRY(choose_device(seen, options.device));
  OpenedDevice opened = open_device(egl, chosen.index, options.debug);
  if (opened.device.problem) return tl::unexpected(*opened.device.problem);
  return std::unique_ptr<GlContext>(new GlContext(std::move(opened.context), std::move(opened.device)));
}

Result<void> GlContext::check(const std::string& doing) const {
  if (context_->reports_resets()) {
    const GLenum status = glGetGraphicsResetStatus();
    if (status != GL_NO_ERROR) return tl::unexpected(lost(reset_text(status), doing));
  }
  Result<void> result;
  constexpr int kMost = 16;  // there are fewer kinds of errors; a driver without a context may report errors forever
  GLenum code = glGetError();
  for (int told = 0; code != GL_NO_ERROR && told < kMost; ++told, code = glGetError()) {
    if (code == GL_CONTEXT_LOST) return tl::unexpected(lost("for an unknown reason", doing));
    if (!result) continue;
    if (code == GL_OUT_OF_MEMORY) {
      result = unavailable(fmt::format("{}: not enough GPU memory while {}", device_.renderer, doing),
                           {{Remedy::lower, Setting::gpu_memory}, {Remedy::use, Setting::cpu_backend}});
    } else {
      result = unavailable(
          fmt::format("{}: {} while {} (OpenGL error 0x{:04X})", device_.renderer, gl_error_words(code), doing, code),
          {{Remedy::report, Setting::devices}, {Remedy::use, Setting::cpu_backend}});
    }
  }
  return result;
}

Error GlContext::lost(std::string_view why, const std::string& doing) const {
  return {ErrorCode::unavailable,
          fmt::format("{}: the driver reset the GPU {} while {}", device_.renderer, why, doing),
          {"try again", {Remedy::use, Setting::cpu_backend}}};
}

const std::vector<std::string>& GlContext::debug_messages() const { return context_->messages(); }

Result<std::vector<GpuDevice>> list_gpu_devices() {
  const auto egl = TRY(egl_devices());
  std::vector<GpuDevice> devices;
  for (int d = 0; d < static_cast<int>(egl.size()); ++d) devices.push_back(open_device(egl, d, false).device);
  return devices;
}

}  // namespace isoextract::gl
