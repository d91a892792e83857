#include "convert/detail/partwise_output.hpp"

namespace isoextract::convert {
namespace {

bool needs_whole_mesh(const ConversionJob& job, const Source& source) {
  const SurfaceEdits& edits = job.edits;
  const bool edits_mesh =
      edits.pieces.drops() || edits.pieces.split || edits.smooth || edits.simplify || edits.touching == Touching::apart;
  const bool examines_mesh = job.verify || job.error || !edits.require.empty();
  const bool has_attributes = !job.source.attributes.empty() || (job.color && job.color->attribute);
  // The normals of caps are known only when the mesh is whole.
  const bool fits_normals = are_per_triangle(job.normals) || (job.normals == Normals::smooth && job.surface.cap);
  return job.writes<MeshFileOptions>() == nullptr || !source.clip.empty() || edits_mesh || examines_mesh ||
         has_attributes || fits_normals;
}

}  // namespace

std::unique_ptr<mesh::MeshSink> partwise_output(const ConversionJob& job, const Source& source, const SurfaceList& all,
                                                const SurfaceId& id, mesh_io::MeshWriter& writer) {
  if (needs_whole_mesh(job, source)) return nullptr;
  return std::make_unique<PartwiseOutput>(writer, [&job, &source, &all, id](const mesh::MeshShape& shape) {
    mesh::Mesh head;
    head.name = source.field.name;
    head.material = material_of(job, all, id, source.field.kind, shape.may_be_open);
    return head;
  });
}

}  // namespace isoextract::convert
