#include "convert/stages/mesh_relax.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/reserved_buffer.hpp"
#include "convert/mesh_pieces.hpp"
#include "convert/stages/surface_stages.hpp"
#include "mesh/components.hpp"

namespace isoextract::convert {
namespace {

constexpr double kSmallShare = 0.001;
constexpr double kSmallPercent = 100 * kSmallShare;

// Volumes in the mesh's units; negative for cavities.
struct RelaxedVolume {
  double before = 0;  // of the voxels
  double after = 0;   // of the mesh

  // Relative change; 0 if there was no volume.
  [[nodiscard]] double change() const { return before != 0 ? after / before - 1 : 0; }
  [[nodiscard]] bool is_large() const { return std::abs(change()) > kSmallShare; }
  [[nodiscard]] bool is_larger_than(const RelaxedVolume& other) const {
    return std::abs(change()) > std::abs(other.change());
  }
};

Figures figures_of(const RelaxedVolume& volume) { return {{Key::before, volume.before}, {Key::after, volume.after}}; }

RelaxedVolume volume_at(const Figures& figures, Key key) {
  return {value_at<double>(figures, {key, Key::before}).value_or(0),
          value_at<double>(figures, {key, Key::after}).value_or(0)};
}

// Returns "from 30 to 3.29 (89 % less)".
std::string text_of(const RelaxedVolume& volume) {
  const double sign = volume.before < 0 ? -1 : 1;  // volumes of cavities are negative
  return fmt::format("from {:.4g} to {:.4g} ({:.3g} % {})", sign * volume.before, sign * volume.after,
                     100 * std::abs(volume.change()), volume.change() > 0 ? "more" : "less");
}

// Returns the volume of the tetrahedron from the apex to a triangle. The apex is a vertex of the component, which keeps
// cancellation small.
double volume_to(std::span<const glm::vec3> positions, const glm::uvec3& triangle, const glm::dvec3& apex) {
  const glm::dvec3 a = glm::dvec3(positions[triangle.x]) - apex;
  const glm::dvec3 b = glm::dvec3(positions[triangle.y]) - apex;
  const glm::dvec3 c = glm::dvec3(positions[triangle.z]) - apex;
  return glm::dot(a, glm::cross(b, c)) / 6;
}

struct Component {
  std::uint32_t apex = mesh::Components::kNone;
  RelaxedVolume volume;
};

struct RelaxedVolumes {
  RelaxedVolume whole;
  RelaxedVolume worst;  // of the component with the largest relative change
  std::uint64_t components = 0;
  std::uint64_t changed = 0;

  void add(const RelaxedVolume& component) {
    ++components;
    whole.before += component.before;
    whole.after += component.after;
    changed += component.is_large() ? 1 : 0;
    if (component.is_larger_than(worst)) worst = component;
  }
};

// Returns the volumes of a closed mesh that is one component.
RelaxedVolumes volumes_of_one(const mesh::Mesh& mesh, double voxels) {
  RelaxedVolumes volumes;
  RelaxedVolume component{voxels, 0};
  const glm::dvec3 apex(mesh.positions[mesh.triangles[0].x]);
  for (const glm::uvec3& triangle : mesh.triangles) {
    component.after += volume_to(mesh.positions.span(), triangle, apex);
  }
  volumes.add(component);
  return volumes;
}

// Returns the volumes of the components, which the triangles that share vertices form.
Result<RelaxedVolumes> volumes_of_components(const mesh::Mesh& mesh, const StageContext& stage) {
  const Context& context = stage.context;
  const edit::OriginalPositions sites = TRY(voxel_sites(mesh, stage.source, stage.job.surface, context));
  const std::string what = mesh.name + ": the volumes of its components";
  const auto labels = TRY(context.reserve(mesh::Components::bytes(mesh.positions.size()), what));
  const mesh::Components components(mesh.triangles.span(), mesh.positions.size());
  auto made = TRY(make_reserved_buffer<Component>(components.count(), context, what));
  Buffer<Component>& list = made->values;
  std::fill(list.begin(), list.end(), Component());
  // On one thread, in the order of the triangles: the sums are the same in every run.
  for (const glm::uvec3& triangle : mesh.triangles) {
    const std::uint32_t number = components.of_vertex(triangle.x);
    if (number == mesh::Components::kNone) continue;
    Component& component = list[number];
    if (component.apex == mesh::Components::kNone) component.apex = triangle.x;
    component.volume.before += volume_to(sites.span(), triangle, glm::dvec3(sites[component.apex]));
    component.volume.after += volume_to(mesh.positions.span(), triangle, glm::dvec3(mesh.positions[component.apex]));
  }
  RelaxedVolumes volumes;
  for (const Component& component : list) volumes.add(component.volume);
  return volumes;
}

}  // namespace

Result<StageReport> measure_relaxing(Surface& surface, const StageContext& stage) {
  // A plane cuts the surface and the voxels at different points, so the two volumes are not comparable.
  if (!stage.job.surface.relaxes() || !stage.source.clip.empty()) return StageReport();
  const mesh::Mesh& mesh = surface.mesh;
  // The volume of a label's voxels is known: most labels are one component, which needs no search.
  const bool is_one = surface.label_components == 1 && !stage.facts.may_be_open && !mesh.triangles.empty();
  const RelaxedVolumes volumes =
      is_one ? volumes_of_one(mesh, surface.label_volume) : TRY(volumes_of_components(mesh, stage));
  StageReport report = stage.report_on(StageName::relax, surface);
  report.entries.push_back(
      {{Key::volume, figures_of(volumes.whole)},
       {Key::components, volumes.components},
       {Key::changed_components, volumes.changed},
       {Key::worst_component, volumes.components > 0 ? Value(figures_of(volumes.worst)) : Value()}});
  return report;
}

std::optional<std::string> note_of_relaxing(std::span<const StageReport> reports) {
  struct Worst {
    std::string surface;
    RelaxedVolume volume;
    void look_at(const std::string& other, const RelaxedVolume& of_it) {
      if (surface.empty() || of_it.is_larger_than(volume)) *this = {other, of_it};
    }
  };
  Worst whole;
  Worst component;
  std::uint64_t surfaces = 0;
  std::uint64_t components = 0;
  std::uint64_t changed_components = 0;
  for (const StageReport& report : reports) {
    if (report.stage != StageName::relax) continue;
    const Figures& figures = report.entries.front();
    if (const RelaxedVolume volume = volume_at(figures, Key::volume); volume.is_large()) {
      ++surfaces;
      whole.look_at(report.subject, volume);
    }
    component.look_at(report.subject, volume_at(figures, Key::worst_component));
    components += value_at<std::uint64_t>(figures, {Key::components}).value_or(0);
    changed_components += value_at<std::uint64_t>(figures, {Key::changed_components}).value_or(0);
  }
  if (changed_components == 0 && surfaces == 0) return std::nullopt;
  std::string text = "relaxing changed the volume of ";
  if (surfaces > 0) text += fmt::format("{} {}", whole.surface, text_of(whole.volume));
  if (surfaces > 1)
    text += fmt::format(", of {} by more than {} %", counted(surfaces - 1, "other surface"), kSmallPercent);
  // Adds nothing if the components that changed are the surfaces already named.
  if (changed_components > surfaces) {
    text +=
        fmt::format("{}{} of {} by more than {} %, most in {}{}, {}", surfaces == 0 ? "" : ", and of ",
                    changed_components, counted(components, "component"), kSmallPercent,
                    component.volume.before < 0 ? "a cavity of " : "", component.surface, text_of(component.volume));
  }
  return text;
}

Result<StageReport> mark_bodies(Surface& surface, const StageContext& stage) {
  if (!stage.job.edits.pieces.split) return StageReport();
  auto sites = TRY(voxel_sites(surface.mesh, stage.source, stage.job.surface, stage.context));
  TRY(edit::mark_bodies(surface.mesh, stage.context, std::move(sites)));
  return StageReport();
}

}  // namespace isoextract::convert
