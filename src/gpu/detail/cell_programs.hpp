// The shader programs of the pipelines, one for each kind of samples and mesh; kept for later extractions.
//
// Shaders are files in the folder shaders. src/gl/CMakeLists.txt lists and embeds them; cell_programs.cpp joins them
// with the case tables of the CPU (case_constants.hpp). Shaders find inside samples by integer comparisons, and compute
// positions in double with `precise`, in the order of extract/edge_geometry.hpp. So both backends agree within the
// limits that `isoextract verify INPUT --iso V` checks. Call GL only on the thread that opened the context.
//
// Tests run on Mesa's llvmpipe, and treat the driver's messages as errors (GpuOptions::debug). llvmpipe repeats
// vertices in a draw of more than 65,536 tessellated vertices, so compare contents, not counts.
#pragma once

#include <map>
#include <string>
#include <tuple>

#include "gl/gl_program.hpp"
#include "gpu/detail/cell_capture.hpp"

namespace isoextract::gpu {

enum class CapturedNormals {
  none,
  flat,      // one a triangle, by the cross product of two edges (Suravikin and Korobitsyn)
  gradient,  // from the gradient of the field at the vertex (Suravikin and Korobitsyn)
};

struct CellProgramKind {
  GpuPipeline pipeline = GpuPipeline::mt_geometry;
  std::string sample_define;  // "SAMPLE_F32"
  bool sparse = false;
  bool scaled = false;  // values differ from the stored numbers
  bool holes = false;   // NanPolicy::hole
  bool swizzle = true;
  bool counting = false;  // for the count pass: emits triangles without computing their vertices
  CapturedNormals normals = CapturedNormals::none;

  friend bool operator<(const CellProgramKind& a, const CellProgramKind& b) {
    const auto tied = [](const CellProgramKind& kind) {
      return std::tie(kind.pipeline, kind.sample_define, kind.sparse, kind.scaled, kind.holes, kind.swizzle,
                      kind.counting, kind.normals);
    };
    return tied(a) < tied(b);
  }
};

class CellPrograms {
 public:
  // Returns the program, linking it at first use. For marching cubes it also binds the texture of triangle lists to
  // unit 2. Fails as ShaderProgram::link() does.
  [[nodiscard]] Result<const gl::ShaderProgram*> find(const gl::GlContext& context, const CellProgramKind& kind);

 private:
  void bind_case_triangles(const gl::ShaderProgram& program);

  std::map<CellProgramKind, gl::ShaderProgram> programs_;
  gl::GlTexture case_triangles_;
};

}  // namespace isoextract::gpu
