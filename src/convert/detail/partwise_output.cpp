#include "convert/detail/partwise_output.hpp"

#include <variant>

#include "convert/stages/surface_stages.hpp"
#include "extract/edge_geometry.hpp"
#include "extract/mesh_assembly.hpp"

namespace isoextract::convert {
namespace {

bool needs_whole_mesh(const ConversionJob& job, const Source& source) {
  const SurfaceEdits& edits = job.edits;
  const bool edits_mesh = edits.pieces.drops() || edits.pieces.split || edits.smooth || edits.hollow || edits.simplify;
  const bool examines_mesh = job.verify || job.error || !edits.require.empty();
  const bool has_attributes = !job.source.attributes.empty() || (job.color && job.color->attribute);
  const auto* file = job.writes<MeshFileOptions>();
  const bool is_stl = file != nullptr && file->format == mesh_io::MeshFormat::stl;  // its writer finds the normals
  // The normals of caps are known only when the mesh is whole.
  const bool fits_normals =
      (are_per_triangle(job.normals) && !is_stl) || (job.normals == Normals::smooth && job.surface.cap);
  return file == nullptr || !source.clip.empty() || edits_mesh || examines_mesh || has_attributes || fits_normals;
}

bool writes_one_surface(const ConversionJob& job) {
  return job.outputs.size() == 1 && job.outputs.front().isos.size() == 1;
}

// Of vertices at equal positions, some would move apart, or only the whole mesh tells what readers find there.
bool needs_distinct_positions(const ConversionJob& job) {
  return job.edits.touching == Touching::apart || mesh_io::mesh_format_info(job.meshes().format).readers_weld;
}

}  // namespace

bool writes_shared_parts(const ConversionJob& job) {
  const auto* meshes = job.writes<MeshFileOptions>();
  const bool takes_parts = meshes != nullptr && !meshes->ascii && !meshes->packing.packs() &&
                           (meshes->format == mesh_io::MeshFormat::ply || meshes->format == mesh_io::MeshFormat::glb);
  return takes_parts && writes_one_surface(job);
}

bool goes_by_parts(const ConversionJob& job, const Source& source, double iso) {
  using extract::Method;
  const auto* file = job.writes<MeshFileOptions>();
  const bool takes_parts = file != nullptr && mesh_io::mesh_format_info(file->format).takes_parts &&
                           !file->packing.packs() && !file->packing.optimize_order && writes_one_surface(job);
  const bool makes_parts = (job.surface.method == Method::mc || job.surface.method == Method::mt) &&
                           !job.surface.heights && job.surface.nan != extract::NanPolicy::hole &&
                           job.backend.backend == Backend::cpu &&
                           std::holds_alternative<field::DenseSamples>(source.field.samples);
  if (!takes_parts || !makes_parts || needs_whole_mesh(job, source)) return false;
  const extract::ExtractOptions options = extract_options_of(job, source, iso);
  const field::IndexBox stored = source.field.extents();
  const auto region = extract::clip_region(source.field, stored, options);
  if (!region) return false;
  const extract::OutputPlacement placement = extract::output_placement(source.field, options, stored, *region);
  return placement.origin() == glm::dvec3(0) && (!needs_distinct_positions(job) || placement.keeps_vertices_apart());
}

void add_partwise_hint(Error& error) {
  if (error.code != ErrorCode::out_of_memory) return;
  error.hint.steps.emplace_back(
      "PLY, GLB, OBJ and STL files take a mesh in parts, unless edits, attributes, measurements or a report need it "
      "whole");
}

std::unique_ptr<mesh::MeshSink> partwise_output(const ConversionJob& job, const Source& source, const SurfaceList& all,
                                                const SurfaceId& id, mesh_io::MeshWriter& writer, Ranks* ranks) {
  if (needs_whole_mesh(job, source)) return nullptr;
  const auto make_head = [&job, &source, &all, id](const mesh::MeshShape& shape) {
    mesh::Mesh head;
    head.name = source.field.name;
    head.material = material_of(job, all, id, source.field.kind, shape.may_be_open);
    return head;
  };
  return std::make_unique<PartwiseOutput>(writer, make_head, ranks, needs_distinct_positions(job));
}

std::string reason_against_sharing(const ConversionJob& job, const Source& source, bool has_sink,
                                   std::string_view backend) {
  using extract::Method;
  const Method method = job.surface.method;
  if (job.source.mesh) return "the input is a mesh";
  if (job.surface.heights || (method != Method::mc && method != Method::mt)) return "only mc and mt work slab by slab";
  if (!has_sink) return "an option or the output needs the whole mesh in one process";
  if (!std::holds_alternative<field::DenseSamples>(source.field.samples)) return "the samples are sparse";
  if (backend != "cpu") return "the GPU extracts the surface";
  if (job.surface.cap) return "a cap needs the whole boundary";
  if (job.surface.nan == extract::NanPolicy::hole) return "holes around NaN samples need the whole mesh";
  return {};
}

}  // namespace isoextract::convert
