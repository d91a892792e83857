// The programs of the pipelines, made for a kind of samples and what a mesh needs, and kept for the next extraction.
#pragma once

#include <map>
#include <string>
#include <tuple>

#include "gl/gl_program.hpp"
#include "gpu/detail/cell_capture.hpp"

namespace isoextract::gpu {

enum class CapturedNormals {
  none,
  flat,      // of each triangle, by the cross product of two edges (Suravikin and Korobitsyn)
  gradient,  // of the field, at the vertex (Suravikin and Korobitsyn)
};

struct CellProgramKind {
  GpuPipeline pipeline = GpuPipeline::mt_geometry;
  std::string sample_define;  // "SAMPLE_F32"
  bool sparse = false;
  bool scaled = false;  // values are not the stored numbers
  bool holes = false;   // NanPolicy::hole
  bool swizzle = true;
  bool counting = false;  // makes triangles without making their vertices: for the count pass
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
  // The texture of triangle lists is bound to unit 2 whenever a program of marching cubes is asked for.
  [[nodiscard]] Result<const gl::CellProgram*> find(const gl::GlContext& context, const CellProgramKind& kind);

 private:
  void bind_case_triangles(const gl::CellProgram& program);

  std::map<CellProgramKind, gl::CellProgram> programs_;
  gl::GlTexture case_triangles_;
};

}  // namespace isoextract::gpu
