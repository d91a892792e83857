#include "cli/edit_plan.hpp"

#include <fmt/format.h>

#include "base/printable.hpp"
#include "batch/output_names.hpp"
#include "batch/output_template.hpp"
#include "cli/plan_parts.hpp"
#include "cli/voxel_plan.hpp"

namespace isoextract::cli {

Result<void> plan_edits(const ConvertFlags& flags, convert::ConversionJob& job) {
  const EditFlags& edits = flags.edits;
  if (!flags.surface.blurs.empty() && flags.labels) {
    return refuse_usage("--blur does not go with --labels: between two labels there is none",
                        "leave --blur out; --smooth smooths the meshes");
  }
  if (edits.split && flags.error) {
    return refuse_usage("--error measures a surface as a whole, and --split-components makes meshes of its pieces",
                        "leave one of them out");
  }
  job.source.blurs = flags.surface.blurs;
  job.edits = edits.chosen();
  if (flags.simplify || flags.triangles) job.edits.simplify = convert::SimplifyChoice{flags.simplify, flags.triangles};
  return {};
}

Result<void> check_piece_outputs(const ConvertFlags& flags, const std::string& path,
                                 const mesh_io::MeshFormatInfo& format) {
  const bool has_word = path.find(convert::kPiecePlaceholder) != std::string::npos;
  if (!flags.edits.split) {
    if (!has_word) return {};
    return refuse_usage(fmt::format("-o {}: {} stands for pieces of a surface, which is written whole", path,
                                    convert::kPiecePlaceholder),
                        "give --split-components");
  }
  if (!has_word) {
    if (format.can_hold_several_meshes) return {};
    return refuse_usage(fmt::format("one {} file holds one mesh, and --split-components may give several", format.name),
                        fmt::format("write one file each with -o {}_{}.{}, or all into a glb",
                                    printable(batch::template_of(batch::stem_of(flags.input.inputs.front()))),
                                    convert::kPiecePlaceholder, format.name));
  }
  if (has_all_labels(flags) || (flags.isos.size() > 1 && path.find("{iso}") == std::string::npos)) {
    return refuse_usage(fmt::format("-o {}: pieces of several surfaces would have the same names", path),
                        has_all_labels(flags) ? "list the labels, and put {iso} into the name as well"
                                              : "put {iso} into the name as well");
  }
  return {};
}

}  // namespace isoextract::cli
