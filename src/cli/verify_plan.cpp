#include <utility>

#include <fmt/format.h>

#include "cli/particle_plan.hpp"
#include "cli/plan.hpp"
#include "cli/plan_parts.hpp"
#include "cli/voxel_plan.hpp"
#include "files/output_file.hpp"

namespace isoextract::cli {
namespace {

// Refuses options that have no effect without a mesh, because backends are compared directly after extraction.
Result<void> check_backends_only(const ConvertFlags& flags) {
  TRY(flags.refuse(About::edit,
                   "{} changes a surface after it is extracted, and without MESH the backends are compared, which only "
                   "extract",
                   "leave {} out, or give the mesh that was written with it"));
  if (flags.labels) {
    return refuse_usage("--labels needs MESH: the GPU backend has no surfaces of labels to compare",
                        "give the mesh that was written with it");
  }
  if (!flags.backend) return {};
  return refuse_usage("--backend needs MESH: without it both backends are compared with each other",
                      "leave --backend out");
}

Result<void> check_mesh_path(const std::string& path, const ConvertFlags& flags,
                             const mesh_io::MeshFormatInfo& format) {
  for (const std::string_view word : {std::string_view("{iso}"), convert::kPiecePlaceholder}) {
    if (path.find(word) == std::string::npos || files::is_there(path)) continue;
    return refuse_usage(fmt::format("{}: verify takes one mesh, and {} stands for several files", path, word),
                        word == convert::kPiecePlaceholder
                            ? "write the pieces into one glb, which is verified as a whole"
                            : "give the files one after the other, each with its own --iso or --labels");
  }
  if (flags.edits.split && !format.can_hold_several_meshes) {
    return refuse_usage(fmt::format("{}: one {} file holds one piece, and which one is not known", path, format.name),
                        "write the pieces into one glb, which is verified as a whole");
  }
  return {};
}

}  // namespace

Result<VerifyPlan> plan_verify(const VerifyFlags& given) {
  ConvertFlags flags = given.conversion;
  if (flags.input.inputs.empty()) return refuse_usage("no INPUT was given", "isoextract verify INPUT --iso V [MESH]");
  TRY(refuse_several_grids(flags.input, "verify"));
  const std::string input = flags.input.inputs.front();
  VerifyPlan plan;
  plan.mesh = given.mesh;
  plan.json = given.json;
  plan.is_placed = flags.placement.any_set();
  mesh_io::MeshFormat format = mesh_io::MeshFormat::glb;  // default placement for comparing backends
  if (plan.mesh) {
    format = TRY(format_of_path(*plan.mesh, mesh_io::mesh_format_by_path(input)
                                                ? "the volume comes first: isoextract verify INPUT MESH"
                                                : "MESH is a mesh that isoextract wrote"));
    TRY(check_mesh_path(*plan.mesh, flags, mesh_io::mesh_format_info(format)));
  } else {
    TRY(check_backends_only(flags));
    flags.verify = true;
  }
  flags.format = OutputFormat{format};
  plan.float32_world = mesh_io::mesh_format_info(format).stores_float32_world;

  TRY(take_labels(flags));
  const Context context(plan_memory(flags.input.memory_limit));
  auto note = TRY(set_default_iso(flags, input, context));
  auto conversion = TRY(plan_conversion(flags, flags.isos, context));
  plan.notes = std::move(conversion.notes);
  if (!note.empty()) plan.notes.push_back(std::move(note));
  plan.context = std::move(conversion.context);
  plan.job = std::move(conversion.job);
  plan.job.source.input = input;
  plan.job.verify = false;
  plan.job.normals = convert::Normals::none;         // triangles do not depend on normals
  plan.job.empty = convert::EmptyPolicy::write;      // an empty mesh is allowed
  plan.job.file = convert::MeshFileOptions{format};  // the mesh file tells its packing
  plan.job.outputs = {{plan.mesh.value_or(""), flags.isos}};
  return plan;
}

}  // namespace isoextract::cli
