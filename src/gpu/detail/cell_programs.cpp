#include "gpu/detail/cell_programs.hpp"

#include "gpu/detail/case_constants.hpp"

namespace isoextract::gpu {
namespace {

gl::ProgramSource source_of(const CellProgramKind& kind) {
  gl::ProgramSource source;
  source.defines = {kind.sample_define, kind.sparse ? "FIELD_SPARSE" : "FIELD_DENSE"};
  if (kind.scaled) source.defines.emplace_back("SCALED");
  if (kind.holes) source.defines.emplace_back("NAN_HOLES");
  if (kind.swizzle) source.defines.emplace_back("SWIZZLE");
  if (kind.counting) source.defines.emplace_back("COUNTING");
  if (kind.normals == CapturedNormals::flat) source.defines.emplace_back("NORMALS_FLAT");
  if (kind.normals == CapturedNormals::gradient) source.defines.emplace_back("NORMALS_GRADIENT");
  if (!kind.counting) source.captured = {"position", "edge_key"};
  if (kind.normals != CapturedNormals::none) source.captured.push_back("normal");
  switch (kind.pipeline) {
    case GpuPipeline::mt_geometry:
      source.constants = tetrahedron_constants();
      source.stages = {{GL_VERTEX_SHADER, {"field.glsl", "mt_geometry.vert"}},
                       {GL_GEOMETRY_SHADER, {"field.glsl", "captured_vertex.glsl", "mt_geometry.geom"}}};
      return source;
    case GpuPipeline::mc_points: source.stages = {{GL_VERTEX_SHADER, {"mc_points.vert"}}}; break;
    case GpuPipeline::mc_tessellation:
      source.stages = {{GL_VERTEX_SHADER, {"mc_tessellation.vert"}},
                       {GL_TESS_CONTROL_SHADER, {"mc_tessellation.tesc"}},
                       {GL_TESS_EVALUATION_SHADER, {"mc_tessellation.tese"}}};
      break;
  }
  source.stages.push_back({GL_GEOMETRY_SHADER, {"field.glsl", "captured_vertex.glsl", "mc.geom"}});
  return source;
}

}  // namespace

Result<const gl::ShaderProgram*> CellPrograms::find(const gl::GlContext& context, const CellProgramKind& kind) {
  auto known = programs_.find(kind);
  if (known == programs_.end()) {
    auto linked = TRY(gl::ShaderProgram::link(context, source_of(kind)));
    known = programs_.emplace(kind, std::move(linked)).first;
  }
  if (kind.pipeline != GpuPipeline::mt_geometry) bind_case_triangles(known->second);
  return &known->second;
}

void CellPrograms::bind_case_triangles(const gl::ShaderProgram& program) {
  glActiveTexture(GL_TEXTURE2);
  if (case_triangles_.name() == 0) {
    case_triangles_ = gl::GlTexture::make();
    glBindTexture(GL_TEXTURE_2D, case_triangles_.name());
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_R8UI, kCaseTexels, 256);
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, kCaseTexels, 256, GL_RED_INTEGER, GL_UNSIGNED_BYTE,
                    cube_case_texels().data());
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  }
  glBindTexture(GL_TEXTURE_2D, case_triangles_.name());
  program.set("case_triangles", 2);
}

}  // namespace isoextract::gpu
