#include "convert/stages/vertex_colors.hpp"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/nearest_name.hpp"
#include "base/printable.hpp"
#include "base/srgb.hpp"
#include "convert/stages/surface_stages.hpp"
#include "edit/vertex_colors.hpp"

namespace isoextract::convert {
namespace {

// Opacity of the outermost of several surfaces. The innermost is opaque; steps between are equal.
constexpr double kOutermostOpacity = 0.25;

// Returns the position from the outermost (0) to the innermost surface (1); 1 for a single surface. Surfaces that have
// the same iso value count once.
double depth_of(std::span<const SurfaceId> rising, const SurfaceId& id, field::FieldKind kind) {
  if (rising.size() < 2) return 1;
  const auto outer = kind == field::FieldKind::density ? std::ranges::lower_bound(rising, id) - rising.begin()
                                                       : rising.end() - std::ranges::upper_bound(rising, id);
  return static_cast<double>(outer) / static_cast<double>(rising.size() - 1);
}

double opacity_of(const ConversionJob& job, const SurfaceList& all, const SurfaceId& id, field::FieldKind kind) {
  if (job.opacity.size() == 1) return job.opacity.front();
  if (!job.opacity.empty()) {
    const auto at = static_cast<std::size_t>(std::ranges::find(all.in_order, id) - all.in_order.begin());
    return job.opacity[std::min(at, job.opacity.size() - 1)];
  }
  const bool by_iso = job.color && !job.color->attribute;
  if (!by_iso) return 1;
  // The surfaces that may enclose this one, or lie inside it.
  std::span<const SurfaceId> around = all.rising;
  std::vector<SurfaceId> same_side;
  if (job.source.away_from_zero) {
    const bool above = kind == field::FieldKind::density;
    std::ranges::copy_if(all.rising, std::back_inserter(same_side),
                         [&](const SurfaceId& other) { return other == id || (above ? other > 0.0 : other < 0.0); });
    around = same_side;
  }
  return kOutermostOpacity + (1 - kOutermostOpacity) * depth_of(around, id, kind);
}

// Keeps the material of a mesh file, with the job's opacity, and double-sided if the mesh is open.
void adjust_material(const ConversionJob& job, bool open, std::optional<mesh::Material>& material) {
  if (job.opacity.empty() && !open) return;
  if (!material) material.emplace();
  if (!job.opacity.empty()) material->opacity = job.opacity.front();
  material->double_sided |= open;
}

// Fails for a mesh of a file without the attribute.
Result<void> check_has(const mesh::Mesh& mesh, const std::string& subject, const std::string& attribute) {
  std::vector<std::string> names;
  for (const mesh::Attribute& found : mesh.attributes) {
    if (found.role == mesh::AttributeRole::other) names.push_back(found.name);
  }
  if (std::ranges::find(names, attribute) != names.end()) return {};
  const std::string near = did_you_mean(attribute, names);
  std::ranges::transform(names, names.begin(), [](const std::string& name) { return printable(name); });
  return fail(ErrorCode::input,
              fmt::format("{}: expected the vertex attribute '{}', found {}{}", subject, printable(attribute),
                          names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", ")), near));
}

Result<StageReport> color_by_attribute(Surface& surface, const StageContext& stage) {
  const ConversionJob& job = stage.job;
  if (!job.color || !job.color->attribute) return StageReport();
  const std::string& attribute = *job.color->attribute;
  if (stage.source.of_meshes) {
    TRY(check_has(surface.mesh, stage.subject(surface), attribute));
  } else if (color_attribute_of(job, stage.source) == nullptr) {
    return StageReport();  // sample_vertex_attributes() or the source has reported it
  }
  edit::ValueColors made;
  if (surface.taken) {
    made = surface.attributes->colors;
  } else {
    made = TRY(color_vertices(surface.mesh, job, job.color->range, stage.context));
  }
  const bool own_range = !job.color->range;
  StageReport report = stage.report_on(StageName::color, surface);
  report.entries.push_back({{Key::attribute, attribute},
                            {Key::map, word_of(job.color->map)},
                            {Key::range, Value(made.range)},
                            {Key::own_range, own_range},
                            {Key::not_numbers, made.not_numbers}});
  report.lines.push_back({fmt::format("colors of {}: {}, {} from {:.6g} to {:.6g}{}", surface.id.name(),
                                      printable(attribute), word_of(job.color->map), made.range[0], made.range[1],
                                      own_range ? ", the range of its vertices" : "")});
  if (made.not_numbers > 0) {
    report.notes.push_back({NoteId::nan_attribute,
                            fmt::format("{}: {} of {} vertices are gray, because '{}' is not a number there",
                                        report.subject, made.not_numbers, surface.vertices(), printable(attribute))});
  }
  drop_unwritten(job, surface.mesh);
  return report;
}

}  // namespace

SurfaceList::SurfaceList(std::vector<SurfaceId> surfaces) : in_order(std::move(surfaces)), rising(in_order) {
  std::ranges::sort(rising);
  rising.erase(std::unique(rising.begin(), rising.end()), rising.end());
}

std::optional<mesh::Material> material_of(const ConversionJob& job, const SurfaceList& all, const SurfaceId& id,
                                          field::FieldKind kind, bool open) {
  const bool by_iso = job.color && !job.color->attribute;
  if (!by_iso && job.opacity.empty() && !open) return std::nullopt;
  mesh::Material material;
  material.double_sided = open;
  material.opacity = opacity_of(job, all, id, kind);
  if (!by_iso) return material;
  const double least = all.rising.front().rounded();
  const double greatest = all.rising.back().rounded();
  const glm::dvec3 color = edit::color_at(
      job.color->map, edit::place_in(job.color->range.value_or(edit::ValueRange{least, greatest}), id.rounded()));
  material.color = glm::dvec3(srgb_to_linear(color.x), srgb_to_linear(color.y), srgb_to_linear(color.z));
  return material;
}

const std::string* color_attribute_of(const ConversionJob& job, const Source& source) {
  if (!job.color || !job.color->attribute || !source.attributes) return nullptr;
  const std::string& attribute = *job.color->attribute;
  const auto is_meant = [&](const MissingAttribute& missing) { return missing.choice.name == attribute; };
  return std::ranges::any_of(source.attributes->missing, is_meant) ? nullptr : &attribute;
}

Result<edit::ValueColors> color_vertices(mesh::Mesh& mesh, const ConversionJob& job,
                                         const std::optional<edit::ValueRange>& range, const Context& context) {
  const bool is_gltf = mesh_io::is_gltf(job.meshes().format);
  return edit::color_by_values(mesh, *job.color->attribute, job.color->map, range,
                               is_gltf ? edit::ColorStorage::linear_u16 : edit::ColorStorage::srgb_u8, context);
}

void drop_unwritten(const ConversionJob& job, mesh::Mesh& mesh) {
  for (const AttributeChoice& choice : job.source.attributes) {
    if (choice.written) continue;
    std::erase_if(mesh.attributes, [&](const mesh::Attribute& a) {
      return a.role != mesh::AttributeRole::color && a.name == choice.name;
    });
  }
}

Result<StageReport> color_surface(Surface& surface, const StageContext& stage) {
  const SurfaceFacts& facts = stage.facts;
  if (stage.source.of_meshes) {
    adjust_material(stage.job, facts.may_be_open, surface.mesh.material);
  } else {
    surface.mesh.material = material_of(stage.job, facts.all, surface.id, stage.source.field.kind, facts.may_be_open);
  }
  if (facts.labels != nullptr) {
    TRY(facts.labels->color(stage.job, surface.id.label(), surface.mesh, stage.context));
  }
  auto report = color_by_attribute(surface, stage);
  // Attributes change only now, because colors depend on the input's values.
  if (const auto& attributes = stage.source.attributes; report && attributes) {
    transform_attributes(surface.mesh, attributes->kinds, attributes->output_from_world);
  }
  return report;
}

}  // namespace isoextract::convert
