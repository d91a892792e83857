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
                   "{} edits an extracted surface, but without MESH verify compares the backends, which only "
                   "extract",
                   "leave {} out, or give the mesh that isoextract wrote with it"));
  if (flags.labels.chosen) {
    return refuse_usage(
        "--labels needs MESH: without MESH, verify compares the CPU with the GPU, which cannot extract labels",
        "give the mesh that isoextract wrote with --labels");
  }
  if (!flags.backend) return {};
  return refuse_usage("--backend needs MESH: without MESH, verify compares both backends with each other",
                      "leave --backend out");
}

Result<void> check_mesh_path(const std::string& path, const ConvertFlags& flags,
                             const mesh_io::MeshFormatInfo& format) {
  for (const std::string_view word : {std::string_view("{iso}"), convert::kPiecePlaceholder}) {
    if (path.find(word) == std::string::npos || files::is_there(path)) continue;
    return refuse_usage(fmt::format("{}: verify takes one mesh, and {} stands for several files", path, word),
                        word == convert::kPiecePlaceholder
                            ? "write all bodies into one glb and verify that file"
                            : "verify the files one after the other, each with its own --iso or --labels");
  }
  if (flags.edits.split && !format.can_hold_several_meshes) {
    return refuse_usage(fmt::format("{}: verify cannot tell which body this {} file holds", path, format.name),
                        "write all bodies into one glb and verify that file");
  }
  return {};
}

}  // namespace

Result<VerifyPlan> plan_verify(const VerifyFlags& given) {
  ConvertFlags flags = given.conversion;
  if (flags.input.inputs.empty()) return refuse_usage("INPUT is missing", "isoextract verify INPUT --iso V [MESH]");
  TRY(refuse_several_grids(flags.input, "verify"));
  const std::string input = flags.input.inputs.front();
  VerifyPlan plan;
  plan.mesh = given.mesh;
  plan.json = given.json;
  plan.is_placed = flags.placement.any_set();
  mesh_io::MeshFormat format = mesh_io::MeshFormat::glb;  // default placement for comparing backends
  if (plan.mesh) {
    format = TRY(format_of_path(*plan.mesh, mesh_io::mesh_format_by_path(input)
                                                ? "give the volume first: isoextract verify INPUT MESH"
                                                : "give a mesh that isoextract wrote as MESH"));
    TRY(check_mesh_path(*plan.mesh, flags, mesh_io::mesh_format_info(format)));
  } else {
    TRY(check_backends_only(flags));
    flags.verify = true;
  }
  flags.format = OutputFormat{format};
  plan.float32_world = mesh_io::mesh_format_info(format).stores_float32_world;

  const Context context(plan_memory(flags.input.memory_limit));
  const std::string labels_note =
      TRY(plan.mesh ? set_default_labels(flags, input, context) : Result<std::string>(std::string()));
  TRY(take_labels(flags));
  auto note = TRY(set_default_iso(flags, input, context));
  auto conversion = TRY(plan_conversion(flags, flags.isos, context));
  plan.notes = std::move(conversion.notes);
  if (!note.empty()) plan.notes.push_back({NoteId::iso_chosen, std::move(note)});
  if (!labels_note.empty()) plan.notes.push_back({NoteId::iso_chosen, labels_note});
  TRY(plan_found_table(flags.labels, input, context, plan.notes, conversion.job));
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
