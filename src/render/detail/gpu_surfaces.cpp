#include "render/detail/gpu_surfaces.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace isoextract::render::detail {
namespace {

constexpr std::uint64_t kDrawTriangles = 1 << 20;  // per draw call; cancellation is checked in between
constexpr std::size_t kColorBatch = 1 << 16;       // vertices

}  // namespace

Result<GpuSurfaces> GpuSurfaces::upload(const gl::GlContext& gl, const Scene& scene, const SurfaceView& view,
                                        GpuMemory& memory, const Context& context) {
  GpuSurfaces made;
  made.scene_ = &scene;
  made.view_ = &view;
  made.triangles_ = view.triangles();
  std::uint64_t triangles = 0;
  std::uint64_t vertices = 0;
  std::uint64_t normals = 0;
  std::uint64_t colors = 0;
  for (std::size_t s = 0; s < scene.surfaces.size(); ++s) {
    const Surface& surface = scene.surfaces[s];
    const std::size_t count = surface.mesh->positions.size();
    Record record{};
    const glm::dvec3& offset = view.view(s).offset;
    std::copy_n(&offset.x, 3, record.offset);
    // Values too large for these types do not occur: take_arrays() refuses such large arrays.
    record.first_triangle = static_cast<std::uint32_t>(triangles);
    record.vertex_base = static_cast<std::int32_t>(vertices);
    record.normal_base = view.is_smooth(s) ? static_cast<std::int32_t>(normals) : -1;
    record.color_base = view.colors(s) != nullptr ? static_cast<std::int32_t>(colors) : -1;
    const glm::vec3 color(surface.color);
    std::copy_n(&color.x, 3, record.color);
    record.opacity = static_cast<float>(surface.opacity);
    made.records_.push_back(record);
    triangles += surface.mesh->triangles.size();
    vertices += count;
    if (view.is_smooth(s)) normals += count;
    if (view.colors(s) != nullptr) colors += count;
    if (surface.mesh->triangles.empty()) continue;
    made.has_opaque_ = made.has_opaque_ || view.is_opaque(s);
    made.has_see_through_ = made.has_see_through_ || !view.is_opaque(s);
  }
  if (made.empty()) return made;
  TRY(made.take_arrays(gl, vertices, normals, colors, memory));
  for (std::size_t s = 0; s < scene.surfaces.size(); ++s) {
    const mesh::Mesh& mesh = *scene.surfaces[s].mesh;
    const Record& record = made.records_[s];
    made.corners_.write(record.first_triangle, mesh.triangles.size(), mesh.triangles.data());
    made.positions_.write(static_cast<std::uint64_t>(record.vertex_base), mesh.positions.size(), mesh.positions.data());
    if (record.normal_base >= 0) {
      made.normals_.write(static_cast<std::uint64_t>(record.normal_base), mesh.normals.size(), mesh.normals.data());
    }
    if (record.color_base >= 0) {
      made.write_colors(*view.colors(s), static_cast<std::uint64_t>(record.color_base));
    }
    TRY(context.check());
  }
  made.record_buffer_ = gl::GlBuffer::make();
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, made.record_buffer_.name());
  glBufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(made.records_.size() * sizeof(Record)),
               made.records_.data(), GL_STATIC_DRAW);
  TRY(gl.check("uploading surfaces"));
  return made;
}

Result<void> GpuSurfaces::take_arrays(const gl::GlContext& gl, std::uint64_t vertices, std::uint64_t normals,
                                      std::uint64_t colors, GpuMemory& memory) {
  const auto take = [&](GpuArray& array, GLenum format, std::uint64_t count, std::uint64_t bytes,
                        const char* what) -> Result<void> {
    array = TRY(GpuArray::make(gl, format, count, bytes, what, memory));
    return {};
  };
  if (auto taken = take(corners_, GL_RGB32UI, triangles_, sizeof(glm::uvec3), "the triangles of surfaces"); !taken) {
    return taken;
  }
  if (auto taken = take(positions_, GL_RGB32UI, vertices, sizeof(glm::vec3), "the vertices of surfaces"); !taken) {
    return taken;
  }
  TRY(take(normals_, GL_RGB32F, normals, sizeof(glm::vec3), "the normals of surfaces"));
  return take(colors_, GL_RGBA32F, colors, sizeof(glm::vec4), "the colors of surfaces");
}

void GpuSurfaces::write_colors(const mesh::Attribute& attribute, std::uint64_t first) const {
  const std::size_t count = attribute.values.size() / attribute.stride();
  std::vector<glm::vec4> batch;
  for (std::size_t from = 0; from < count; from += kColorBatch) {
    batch.clear();
    for (std::size_t v = from; v < std::min(count, from + kColorBatch); ++v) {
      batch.emplace_back(vertex_color(attribute, v));
    }
    colors_.write(first + from, batch.size(), batch.data());
  }
}

void GpuSurfaces::bind_triangles(const gl::ShaderProgram& program) const {
  corners_.bind(program, "triangle_corners", TextureUnit::triangle_corners);
  positions_.bind(program, "vertex_positions", TextureUnit::vertex_positions);
  program.set("view_linear", view_->view(0).linear);  // equal for all surfaces
}

void GpuSurfaces::bind_shading(const gl::ShaderProgram& program) const {
  normals_.bind(program, "vertex_normals", TextureUnit::vertex_normals);
  colors_.bind(program, "vertex_colors", TextureUnit::vertex_colors);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, record_buffer_.name());
  program.set("surface_count", static_cast<int>(records_.size()));
  program.set("rotation", glm::mat3(view_->rotation()));
  const ShadingModel& shading = scene_->shading;
  program.set("shading_terms",
              glm::vec4(glm::dvec4(shading.ambient, shading.diffuse, shading.specular, shading.shininess)));
  std::vector<glm::vec3> towards;
  std::vector<glm::vec3> colors;
  for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
    towards.emplace_back(view_->towards(l));
    colors.emplace_back(scene_->lights[l].color);
  }
  program.set("light_count", static_cast<int>(towards.size()));
  if (towards.empty()) return;
  program.set("light_towards", towards);
  program.set("light_colors", colors);
}

Result<void> GpuSurfaces::draw(const gl::GlContext& gl, const gl::ShaderProgram& program, bool hiding,
                               const Context& context) const {
  program.use();
  for (std::size_t s = 0; s < records_.size(); ++s) {
    if (view_->is_opaque(s) != hiding) continue;
    const Record& record = records_[s];
    const std::uint64_t count = scene_->surfaces[s].mesh->triangles.size();
    program.set("vertex_base", record.vertex_base);
    program.set("view_offset", view_->view(s).offset);
    for (std::uint64_t first = 0; first < count; first += kDrawTriangles) {
      program.set("first_triangle", static_cast<int>(record.first_triangle + first));
      glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(3 * std::min(kDrawTriangles, count - first)));
      if (count <= kDrawTriangles) continue;
      glFinish();
      TRY(context.check());
    }
  }
  return gl.check("drawing surfaces");
}

}  // namespace isoextract::render::detail
