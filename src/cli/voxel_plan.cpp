#include "cli/voxel_plan.hpp"

#include <fmt/format.h>

#include "cli/plan_parts.hpp"
#include "extract/method.hpp"
#include "volume_io/label_table.hpp"

namespace isoextract::cli {

Result<void> take_labels(ConvertFlags& flags) {
  if (!flags.labels) {
    if (!flags.label_names) return {};
    return refuse_usage("--label-names is about labels, and none are asked for", "give --labels all");
  }
  if (!flags.surface.method) flags.surface.method = extract::Method::surface_nets;
  const extract::MethodInfo& method = extract::method_info(*flags.surface.method);
  if (method.method != extract::Method::voxels && method.method != extract::Method::surface_nets) {
    return refuse_usage(
        fmt::format("--labels does not go with {}, whose surfaces pass between values, and labels have no order",
                    method.title),
        "leave out --method, or give --method voxels");
  }
  TRY(refuse_both(flags.labels, flags.isos));
  TRY(refuse_both(flags.labels, flags.batch.iso_table));
  if (has_all_labels(flags) && flags.output && flags.output->find("{iso}") != std::string::npos) {
    return refuse_usage("--labels all does not go with {iso} in -o: which labels there are is known once they are read",
                        "list the labels, which 'isoextract info' shows, or write all into a glb");
  }
  flags.isos = *flags.labels;
  return {};
}

Result<void> plan_labels(const ConvertFlags& flags, convert::ConversionJob& job) {
  if (!flags.labels) return {};
  if (flags.input.inside) {
    return refuse_usage("--inside does not go with --labels: inside are the samples of a label, which have no order",
                        "leave --inside out");
  }
  if (flags.input.component && !flags.input.component->number) {
    return refuse_usage("--component length does not go with --labels: a length of labels is no label",
                        "choose one component with --component K");
  }
  if (flags.surface.kernel.value_or(field::ResampleKernel::nearest) != field::ResampleKernel::nearest) {
    return refuse_usage(fmt::format("--kernel {} does not go with --labels: between two labels there is none",
                                    word_of(*flags.surface.kernel)),
                        "leave --kernel out: samples of another grid are the nearest ones of the label map");
  }
  if (job.source.resamples()) job.source.kernel = field::ResampleKernel::nearest;
  if (!flags.label_names) return {};
  const auto table = TRY(volume_io::LabelTable::read(*flags.label_names, Context()));
  job.label_names = convert::LabelTableFile{*flags.label_names, table.hash()};
  return {};
}

bool has_all_labels(const ConvertFlags& flags) {
  return flags.labels && flags.labels->front().kind == convert::IsoChoice::Kind::all_labels;
}

Result<void> plan_voxels(const ConvertFlags& flags, std::vector<std::string>& notes, convert::SurfaceOptions& surface) {
  const extract::MethodInfo& method = extract::method_info(surface.method);
  if (method.traits.always_closed && surface.cap && flags.surface.clip.empty()) {
    notes.push_back(fmt::format("--cap changes nothing: the surface of {} is closed everywhere", method.title));
  }
  if (surface.nan == extract::NanPolicy::hole && !extract::why_no_holes(method).empty()) {
    return refuse_usage(fmt::format("--nan hole: {}", extract::why_no_holes(method)), "--nan outside needs none");
  }
  if (flags.relaxations && surface.method != extract::Method::surface_nets) {
    return refuse_usage(fmt::format("--relax does not go with {}", method.title), "give --method surface-nets");
  }
  surface.relaxations = flags.relaxations.value_or(surface.relaxations);
  if (flags.labels && (flags.simplify || flags.triangles || flags.edits.smooth)) {
    notes.push_back(
        fmt::format("{} changes the mesh of each label by itself: borders that they share part from each other",
                    flags.simplify    ? flags.simplify.name()
                    : flags.triangles ? flags.triangles.name()
                                      : flags.edits.smooth.name()));
  }
  if (flags.edits.smooth && flags.t_junctions) {
    return refuse_usage("--smooth does not go with --t-junctions: corners in the middle of edges would leave them",
                        "leave --t-junctions out");
  }
  if (flags.edits.smooth && surface.method == extract::Method::voxels && !flags.no_merge) {
    // Merged faces can be as long as the mesh; smoothing such triangles would destroy the shape.
    surface.voxel_faces = extract::VoxelFaces::plain;
    notes.emplace_back("--smooth moves the faces of voxels one by one: they are not merged");
  }
  if (!flags.no_merge && !flags.t_junctions) return {};
  TRY(refuse_both(flags.no_merge, flags.t_junctions, "faces by themselves have no T-junctions"));
  if (surface.method != extract::Method::voxels) {
    TRY(flags.refuse(About::voxel_faces,
                     fmt::format("{{}} does not go with {}, which has no faces to merge", method.title),
                     "give --method voxels"));
  }
  surface.voxel_faces = flags.no_merge ? extract::VoxelFaces::plain : extract::VoxelFaces::rectangles;
  return {};
}

}  // namespace isoextract::cli
