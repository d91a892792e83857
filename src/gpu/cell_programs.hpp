// The programs of the pipelines, made for a kind of samples and what a mesh needs, and kept for the next extraction.
#pragma once

#include <map>
#include <string>
#include <tuple>

#include "gpu/cell_capture.hpp"
#include "gpu/gl_program.hpp"

namespace isoextract {

enum class CapturedNormals {
  none,
  flat,      // of each triangle, by the cross product of two edges (seed S1)
  gradient,  // of the field, at the vertex (seed S1)
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
  [[nodiscard]] Result<const CellProgram*> find(const GlContext& context, const CellProgramKind& kind);

 private:
  void bind_case_triangles(const CellProgram& program);

  std::map<CellProgramKind, CellProgram> programs_;
  GlTexture case_triangles_;
};

}  // namespace isoextract
