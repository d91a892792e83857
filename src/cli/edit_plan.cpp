#include "cli/edit_plan.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "batch/output_names.hpp"
#include "batch/output_template.hpp"
#include "cli/plan_parts.hpp"
#include "cli/voxel_plan.hpp"

namespace isoextract::cli {

Result<void> plan_edits(const ConvertFlags& flags, convert::ConversionJob& job) {
  const EditFlags& edits = flags.edits;
  if (edits.split && flags.error) {
    return refuse_usage("--error measures a whole surface, and --split-components writes each body as its own mesh",
                        "leave one of them out");
  }
  if (edits.repair && !job.source.mesh) {
    return refuse_usage("--repair works on mesh files, and the input is no mesh file", "leave --repair out");
  }
  if (edits.hollow && flags.error) {
    return refuse_usage(
        "--error measures the distance to the isosurface, and the inner wall of --hollow is not part of it",
        "leave one of them out");
  }
  if (edits.hollow && flags.labels.chosen && (flags.simplify || flags.triangles)) {
    return refuse_usage(
        "--hollow does not work with --simplify or --triangles on labels, which keep the faces between labels",
        "leave one of them out");
  }
  job.source.blurs = flags.surface.blurs;
  job.edits = edits.chosen();
  if (flags.simplify || flags.triangles) job.edits.simplify = convert::SimplifyChoice{flags.simplify, flags.triangles};
  const auto* const file = job.writes<convert::MeshFileOptions>();
  const bool readers_weld = file != nullptr && mesh_io::mesh_format_info(file->format).readers_weld;
  job.edits.touching = flags.touching.value_or(readers_weld ? convert::Touching::apart : convert::Touching::keep);
  job.edits.require = flags.required.value_or(std::vector<check::Requirement>());
  if (std::ranges::find(job.edits.require, check::Requirement::normals) != job.edits.require.end()) {
    return refuse_usage(
        "--require normals checks a written file, but the conversion checks the mesh before it writes the file",
        "run isoextract check --require normals on the file");
  }
  return {};
}

Result<void> check_piece_outputs(const ConvertFlags& flags, const std::string& path,
                                 const mesh_io::MeshFormatInfo& format) {
  const bool has_word = path.find(convert::kPiecePlaceholder) != std::string::npos;
  if (!flags.edits.split) {
    if (!has_word) return {};
    return refuse_usage(
        fmt::format("-o {}: {} is the number of a body and needs --split-components", path, convert::kPiecePlaceholder),
        "give --split-components if the output is a surface, or leave {piece} out of the name");
  }
  if (!has_word) {
    if (format.can_hold_several_meshes) return {};
    return refuse_usage(
        fmt::format("one {} file holds one mesh, and --split-components may write several", format.name),
        fmt::format("write one file per body with -o {}_{}.{}, or all bodies into one glb",
                    printable(batch::template_of(batch::stem_of(flags.input.inputs.front()))),
                    convert::kPiecePlaceholder, format.name));
  }
  const bool tells_apart = path.find("{iso}") != std::string::npos ||
                           path.find(convert::kLabelPlaceholder) != std::string::npos ||
                           path.find(convert::kNamePlaceholder) != std::string::npos;
  const bool is_set = flags.labels.is_set_of_labels() && !flags.labels.chosen->front().is_label_name();
  if ((is_set || flags.isos.size() > 1) && !tells_apart) {
    return refuse_usage(fmt::format("-o {}: bodies of several surfaces would have the same file names", path),
                        is_set ? "put {label} into the file name as well" : "put {iso} into the file name as well");
  }
  return {};
}

}  // namespace isoextract::cli
