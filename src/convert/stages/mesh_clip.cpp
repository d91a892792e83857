#include "convert/stages/mesh_clip.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "convert/attribute_kinds.hpp"
#include "convert/stages/surface_stages.hpp"
#include "edit/half_space_clip.hpp"

namespace isoextract::convert {

std::vector<mesh::HalfSpace> half_spaces_of(const field::ScalarField& field, const field::Affine& output_from_index,
                                            Space space, const std::vector<ClipPlane>& planes) {
  const field::Affine given_from_output = request_from_index(field, space).after(output_from_index.inverse());
  std::vector<mesh::HalfSpace> kept;
  for (const ClipPlane& plane : planes) {
    const glm::dvec3 turned = glm::transpose(given_from_output.linear) * plane.normal;
    const double length = glm::length(turned);
    kept.push_back({turned / length, (plane.offset - glm::dot(plane.normal, given_from_output.offset)) / length});
  }
  return kept;
}

Result<StageReport> clip_surface(Surface& surface, const StageContext& stage) {
  if (stage.source.clip.empty()) return StageReport();
  const bool capped = stage.job.surface.cap;
  const auto ends = capped ? edit::CutClosing::capped : edit::CutClosing::open;
  StageReport report = stage.report_on(StageName::clip, surface);
  if (!surface.id.is_file_mesh() && !surface.id.is_only_surface())
    report.subject = fmt::format("{} {}", stage.source.label, surface_text(surface.asked));
  // Snapping distance in shortest voxel edges; equal for all surfaces, so that neighbors keep common vertices.
  constexpr double kSnap = 0.001;
  const glm::dmat3& voxel = stage.source.output_from_index.linear;
  const double edge = std::min({glm::length(voxel[0]), glm::length(voxel[1]), glm::length(voxel[2])});
  auto clipped = edit::clip_to_half_spaces(surface.mesh, stage.source.clip, {ends, kSnap * edge}, stage.context);
  if (!clipped) {
    clipped.error().message = fmt::format("{}: {}", report.subject, clipped.error().message);
    return tl::unexpected(std::move(clipped.error()));
  }
  const edit::ClipFigures& facts = *clipped;
  if (facts.triangles_cut + facts.cap_triangles > 0) {
    // Interpolated normals are shorter than 1.
    transform_attributes(surface.mesh, stage.source.mesh_kinds, field::Affine());
  }
  if (!capped) {
    surface.open_boundary.cut = facts.triangles_cut > 0;
    surface.open_boundary.needs_count = true;
  }
  if (facts.triangles_cut == 0 && facts.triangles_after == facts.triangles_before) {
    // No note for a region that holds the whole surface, as most do.
    if (!stage.job.source.clip.empty()) {
      report.notes.push_back(
          {NoteId::clipped,
           fmt::format(
               "{}: clipping cut nothing off; the mesh keeps {}", report.subject,
               facts.triangles_after == 1 ? "its triangle" : fmt::format("all {} triangles", facts.triangles_after))});
    }
    return report;
  }
  // Cutting can split a triangle into several, so more triangles may be left than before.
  std::string text = facts.triangles_cut > 0
                         ? fmt::format("{}: clipping cut {}; the mesh has {} instead of {}", report.subject,
                                       counted(facts.triangles_cut, "triangle"),
                                       counted(facts.triangles_after, "triangle"), facts.triangles_before)
                         : fmt::format("{}: clipping kept {} of {} and cut none", report.subject, facts.triangles_after,
                                       counted(facts.triangles_before, "triangle"));
  NoteId id = NoteId::clipped;
  if (facts.cap_triangles > 0) {
    text += fmt::format("; {} triangles close the surface at the cuts", facts.cap_triangles);
  } else if (facts.triangles_cut > 0 && facts.triangles_after > 0) {
    text += "; the surface is open at the cuts";
    id = NoteId::open_mesh;
  }
  report.notes.push_back({id, std::move(text)});
  if (facts.overlapping_cap_triangles > 0) {
    report.notes.push_back({NoteId::cap_overlaps, fmt::format("{}: {} triangles that close the cuts overlap others, "
                                                              "because the surface intersects or touches itself there",
                                                              report.subject, facts.overlapping_cap_triangles)});
  }
  return report;
}

}  // namespace isoextract::convert
