#include "convert/mesh_clip.hpp"

#include <utility>

#include <fmt/format.h>

namespace isoextract::convert {

std::vector<mesh::HalfSpace> half_spaces_of(const field::ScalarField& field, const field::Affine& output_from_index,
                                            Space space, const std::vector<ClipPlane>& planes) {
  const field::Affine given_from_output = given_from_index(field, space).after(output_from_index.inverse());
  std::vector<mesh::HalfSpace> kept;
  for (const ClipPlane& plane : planes) {
    const glm::dvec3 turned = glm::transpose(given_from_output.linear) * plane.normal;
    const double length = glm::length(turned);
    kept.push_back({turned / length, (plane.offset - glm::dot(plane.normal, given_from_output.offset)) / length});
  }
  return kept;
}

Result<edit::ClipFacts> clip_mesh(mesh::Mesh& mesh, const ConversionJob& job, const Source& source,
                                  const std::string& label, const Context& context, Events& events) {
  if (source.clip.empty()) return edit::ClipFacts{};
  const auto ends = job.surface.cap ? edit::CutEnds::capped : edit::CutEnds::open;
  auto facts = edit::clip_to_half_spaces(mesh, source.clip, ends, context);
  if (!facts) {
    Error error = facts.error();
    error.message = fmt::format("{}: {}", label, error.message);
    return tl::unexpected(std::move(error));
  }
  if (facts->triangles_cut == 0 && facts->triangles_after == facts->triangles_before) {
    // A region may hold all of the surface, and mostly does.
    if (!job.source.clip.empty())
      events.note(fmt::format("{}: nothing was cut off, all {} triangles are left", label, facts->triangles_after));
    return facts;
  }
  // Cut triangles may become several: there may be more than before.
  std::string text = facts->triangles_cut > 0
                         ? fmt::format("{}: {} triangles were cut; {} are left in place of {}", label,
                                       facts->triangles_cut, facts->triangles_after, facts->triangles_before)
                         : fmt::format("{}: {} of {} triangles are left, and none was cut", label,
                                       facts->triangles_after, facts->triangles_before);
  if (facts->cap_triangles > 0) {
    text += fmt::format("; the surface is closed by {} triangles there", facts->cap_triangles);
  } else if (facts->triangles_cut > 0 && facts->triangles_after > 0) {
    text += "; the surface is open there";
  }
  events.note(text);
  if (facts->caps_overlap > 0) {
    events.note(
        fmt::format("{}: {} triangles of the cut overlap others, as the surface passes through or touches itself there",
                    label, facts->caps_overlap));
  }
  return facts;
}

}  // namespace isoextract::convert
