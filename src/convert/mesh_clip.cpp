#include "convert/mesh_clip.hpp"

#include <utility>

#include <fmt/format.h>

namespace isoextract::convert {

std::vector<mesh::HalfSpace> half_spaces_of(const field::ScalarField& field, const field::Affine& output_from_index,
                                            Space space, const std::vector<ClipPlane>& planes,
                                            const std::optional<field::Box>& box) {
  const field::Affine given_from_output = given_from_index(field, space).after(output_from_index.inverse());
  std::vector<mesh::HalfSpace> kept;
  const auto add = [&](const glm::dvec3& normal, double offset) {
    const glm::dvec3 turned = glm::transpose(given_from_output.linear) * normal;
    const double length = glm::length(turned);
    kept.push_back({turned / length, (offset - glm::dot(normal, given_from_output.offset)) / length});
  };
  for (const ClipPlane& plane : planes) add(plane.normal, plane.offset);
  for (int axis = 0; box && axis < 3; ++axis) {
    glm::dvec3 normal(0);
    normal[axis] = 1;
    add(normal, box->min[axis]);
    add(-normal, -box->max[axis]);
  }
  return kept;
}

Result<void> clip_mesh(mesh::Mesh& mesh, std::span<const mesh::HalfSpace> kept, edit::CutEnds ends,
                       const std::string& label, const Context& context, Events& events) {
  if (kept.empty()) return {};
  const auto facts = edit::clip_to_half_spaces(mesh, kept, ends, context);
  if (!facts) {
    Error error = facts.error();
    error.message = fmt::format("{}: {}", label, error.message);
    return tl::unexpected(std::move(error));
  }
  if (facts->triangles_cut == 0 && facts->triangles_after == facts->triangles_before) {
    events.note(fmt::format("{}: nothing was cut off, all {} triangles are left", label, facts->triangles_after));
    return {};
  }
  std::string text =
      fmt::format("{}: {} of {} triangles are left", label, facts->triangles_after, facts->triangles_before);
  text += facts->triangles_cut > 0 ? fmt::format(", after {} were cut", facts->triangles_cut) : ", and none was cut";
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
  return {};
}

}  // namespace isoextract::convert
