// Linked shader programs: some capture their output by transform feedback, others draw pictures.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "gl/gl_context.hpp"
#include "gl/gl_object.hpp"

namespace isoextract::gl {

struct ShaderStage {
  GLenum type;                          // GL_VERTEX_SHADER, ...
  std::vector<std::string_view> parts;  // names of shader files, concatenated in this order; at least one
};

struct ProgramSource {
  std::vector<std::string> defines;  // "SAMPLE_F32"
  std::string constants;             // GLSL text before the first part of each stage
  std::vector<ShaderStage> stages;
  std::vector<const char*> captured;  // captured varyings, interleaved; may be empty
};

// A linked program. Setting a uniform that it does not use has no effect.
class ShaderProgram {
 public:
  // Compiles and links the stages. Fails with ErrorCode::unavailable; the message contains the log of the driver.
  [[nodiscard]] static Result<ShaderProgram> link(const GlContext& context, const ProgramSource& source);

  void use() const { glUseProgram(program_.name()); }

  [[nodiscard]] GLint location(const char* name) const { return glGetUniformLocation(program_.name(), name); }
  void set(const char* name, int value) const { glProgramUniform1i(program_.name(), location(name), value); }
  void set(const char* name, double value) const { glProgramUniform1d(program_.name(), location(name), value); }
  void set(const char* name, const glm::ivec3& v) const {
    glProgramUniform3i(program_.name(), location(name), v.x, v.y, v.z);
  }
  void set(const char* name, const glm::ivec2& v) const {
    glProgramUniform2i(program_.name(), location(name), v.x, v.y);
  }
  void set(const char* name, const glm::uvec2& v) const {
    glProgramUniform2ui(program_.name(), location(name), v.x, v.y);
  }
  void set(const char* name, const glm::dvec2& v) const {
    glProgramUniform2d(program_.name(), location(name), v.x, v.y);
  }
  void set(const char* name, const glm::dvec3& v) const {
    glProgramUniform3d(program_.name(), location(name), v.x, v.y, v.z);
  }
  void set(const char* name, const glm::dmat3& m) const {
    glProgramUniformMatrix3dv(program_.name(), location(name), 1, GL_FALSE, &m[0][0]);
  }
  void set(const char* name, float value) const { glProgramUniform1f(program_.name(), location(name), value); }
  void set(const char* name, const glm::vec4& v) const {
    glProgramUniform4f(program_.name(), location(name), v.x, v.y, v.z, v.w);
  }
  void set(const char* name, const glm::mat3& m) const {
    glProgramUniformMatrix3fv(program_.name(), location(name), 1, GL_FALSE, &m[0][0]);
  }
  // Sets an array from its first element on.
  void set(const char* name, std::span<const glm::vec3> values) const {
    glProgramUniform3fv(program_.name(), location(name), static_cast<GLsizei>(values.size()),
                        values.empty() ? nullptr : &values[0].x);
  }

 private:
  GlProgram program_;
};

// The programs of the count pass and the capture pass over the same cells.
struct CountAndCapture {
  const ShaderProgram* count = nullptr;
  const ShaderProgram* capture = nullptr;

  [[nodiscard]] std::array<const ShaderProgram*, 2> programs() const { return {count, capture}; }
};

}  // namespace isoextract::gl
