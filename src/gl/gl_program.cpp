#include "gl/gl_program.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "gl/detail/shader_text.hpp"

namespace isoextract::gl {
namespace {

std::string log_of(GLuint object, decltype(glGetShaderiv) parameter, decltype(glGetShaderInfoLog) log) {
  GLint length = 0;
  parameter(object, GL_INFO_LOG_LENGTH, &length);
  std::string text(static_cast<std::size_t>(std::max(length, 1)), '\0');
  log(object, length, nullptr, text.data());
  while (!text.empty() && (text.back() == '\0' || text.back() == '\n')) text.pop_back();
  return text;
}

Error broken(const GlContext& context, std::string_view what, const std::string& log) {
  return {ErrorCode::unavailable,
          fmt::format("{}: the driver rejects {}: {}", context.device().renderer, what, log),
          {{Remedy::report, Setting::devices}, {Remedy::use, Setting::cpu_backend}}};
}

}  // namespace

Result<ShaderProgram> ShaderProgram::link(const GlContext& context, const ProgramSource& source) {
  ShaderProgram result;
  result.program_ = GlProgram::make();
  const GLuint program = result.program_.name();
  std::string head = "#version 430 core\n";
  for (const std::string& define : source.defines) head += fmt::format("#define {}\n", define);
  head += source.constants;
  std::vector<GLuint> shaders;
  std::optional<Error> error;
  for (const ShaderStage& stage : source.stages) {
    std::string text = head;
    for (const std::string_view part : stage.parts) text += fmt::format("#line 1\n{}\n", shader_text(part));
    const GLuint shader = glCreateShader(stage.type);
    const char* pointer = text.c_str();
    glShaderSource(shader, 1, &pointer, nullptr);
    glCompileShader(shader);
    GLint compiled = GL_FALSE;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_FALSE && !error) {
      error = broken(context, stage.parts.back(), log_of(shader, glGetShaderiv, glGetShaderInfoLog));
    }
    glAttachShader(program, shader);
    shaders.push_back(shader);
  }
  if (!error) {
    if (!source.captured.empty()) {
      glTransformFeedbackVaryings(program, static_cast<GLsizei>(source.captured.size()), source.captured.data(),
                                  GL_INTERLEAVED_ATTRIBS);
    }
    glLinkProgram(program);
    GLint linked = GL_FALSE;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked == GL_FALSE) {
      error = broken(context, "the shader program", log_of(program, glGetProgramiv, glGetProgramInfoLog));
    }
  }
  for (const GLuint shader : shaders) {
    glDetachShader(program, shader);
    glDeleteShader(shader);
  }
  if (error) return tl::unexpected(*error);
  return result;
}

}  // namespace isoextract::gl
