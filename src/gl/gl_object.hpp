// Owned names of GL objects. Make and destroy them on the thread of the context, while the context is current.
#pragma once

#include <epoxy/gl.h>

#include <utility>

namespace isoextract::gl {

template <class Traits>
class GlObject {
 public:
  GlObject() = default;
  [[nodiscard]] static GlObject make() {
    GlObject object;
    Traits::make(&object.name_);
    return object;
  }
  GlObject(GlObject&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlObject& operator=(GlObject&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  GlObject(const GlObject&) = delete;
  GlObject& operator=(const GlObject&) = delete;
  ~GlObject() {
    if (name_ != 0) Traits::drop(&name_);
  }

  [[nodiscard]] GLuint name() const { return name_; }

 private:
  GLuint name_ = 0;
};

struct GlBufferTraits {
  static void make(GLuint* name) { glGenBuffers(1, name); }
  static void drop(const GLuint* name) { glDeleteBuffers(1, name); }
};
struct GlTextureTraits {
  static void make(GLuint* name) { glGenTextures(1, name); }
  static void drop(const GLuint* name) { glDeleteTextures(1, name); }
};
struct GlQueryTraits {
  static void make(GLuint* name) { glGenQueries(1, name); }
  static void drop(const GLuint* name) { glDeleteQueries(1, name); }
};
struct GlFramebufferTraits {
  static void make(GLuint* name) { glGenFramebuffers(1, name); }
  static void drop(const GLuint* name) { glDeleteFramebuffers(1, name); }
};
struct GlProgramTraits {
  static void make(GLuint* name) { *name = glCreateProgram(); }
  static void drop(const GLuint* name) { glDeleteProgram(*name); }
};

using GlBuffer = GlObject<GlBufferTraits>;
using GlTexture = GlObject<GlTextureTraits>;
using GlQuery = GlObject<GlQueryTraits>;
using GlFramebuffer = GlObject<GlFramebufferTraits>;
using GlProgram = GlObject<GlProgramTraits>;

}  // namespace isoextract::gl
