#include "convert/detail/mesh_source.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/printable.hpp"
#include "base/srgb.hpp"
#include "convert/detail/place_report.hpp"
#include "convert/placement_record.hpp"
#include "convert/stages/mesh_clip.hpp"
#include "edit/vertex_colors.hpp"
#include "files/file_bytes.hpp"
#include "mesh/mesh_part.hpp"
#include "mesh/metrics.hpp"
#include "mesh_io/mesh_reader.hpp"

namespace isoextract::convert {
namespace {

using mesh_io::MeshFile;
using mesh_io::MeshPart;

// Returns a field without samples. Its world coordinates are those of the file.
field::ScalarField frame_of(const MeshFile& file, const std::string& label,
                            const std::optional<ResolvedPlacement>& record) {
  field::ScalarField frame;
  frame.source = label;
  frame.format = std::string(file.format);
  frame.length_unit = file.y_up ? std::string(meter().name) : record ? record->placement.to_unit : std::string();
  frame.index_to_world = field::scaling(glm::dvec3(mesh::typical_edge(file.mesh)));
  frame.samples = field::SparseSamples();
  return frame;
}

StageReport report_of_reading(const MeshFile& file, const std::string& input, const std::string& label,
                              const StageTime& time) {
  std::error_code none;
  const std::uintmax_t bytes = std::filesystem::file_size(input, none);
  StageReport report = report_on(StageName::read_mesh, label);
  report.add_timed({{Key::path, input},
                    {Key::format, file.format},
                    {Key::file_bytes, none ? Value() : Value(bytes)},
                    {Key::parts, std::max<std::size_t>(file.parts.size(), 1)},
                    {Key::vertices, file.mesh.positions.size()},
                    {Key::triangles, file.mesh.triangles.size()}},
                   time);
  report.did = "read";
  return report;
}

// Resolves the placement. Unlike place_field(), which knows only samples, centers the bounds of the mesh.
Result<PlacedField> place_mesh(const field::ScalarField& frame, Placement placement, const mesh::Mesh& mesh) {
  const bool center = std::exchange(placement.center, false);
  auto placed = TRY(place_field(frame, placement, std::nullopt, RegionEnds::faces));
  ResolvedPlacement& resolved = placed.placement;
  resolved.placement.center = center;
  if (!center || mesh.positions.empty()) return placed;
  const mesh::Bounds bounds = mesh::measure_bounds(mesh);
  resolved.moved_by = -resolved.output_from_world()(0.5 * (bounds.min + bounds.max));
  placed.output_from_index.offset += resolved.moved_by;
  return placed;
}

// Stores colors as the output's format does: glTF has linear light, other formats have sRGB.
Result<void> adapt_colors(const MeshFile& file, mesh_io::MeshFormat format, const Context& context, mesh::Mesh& mesh) {
  const bool to_linear = mesh_io::is_gltf(format);
  if (file.y_up == to_linear) return {};
  return edit::store_colors(mesh, file.y_up, to_linear ? edit::ColorStorage::linear_u16 : edit::ColorStorage::srgb_u8,
                            context);
}

// For an output format without materials: adds a note about the lost materials. For PLY, also gives the vertices the
// colors of their materials, unless they have colors already.
Result<void> adapt_materials(const MeshFile& file, mesh_io::MeshFormat format, const std::string& label,
                             const Context& context, Events& events, mesh::Mesh& mesh) {
  const auto has_material = [](const MeshPart& part) { return part.material.has_value(); };
  const auto count = std::ranges::count_if(file.parts, has_material);
  if (count == 0 || mesh_io::is_gltf(format)) return {};
  const auto has_color = [](const MeshPart& part) { return part.material && part.material->color; };
  const bool colored = std::ranges::any_of(
      mesh.attributes, [](const mesh::Attribute& attribute) { return attribute.role == mesh::AttributeRole::color; });
  const bool to_vertices = format == mesh_io::MeshFormat::ply && !colored && std::ranges::any_of(file.parts, has_color);
  if (to_vertices) {
    std::vector<edit::RangeColor> colors;
    for (const MeshPart& part : file.parts) {
      if (!has_color(part)) continue;
      const glm::dvec3& linear = *part.material->color;
      colors.push_back({part.first_vertex,
                        part.vertices,
                        {linear_to_srgb(linear.x), linear_to_srgb(linear.y), linear_to_srgb(linear.z)}});
    }
    TRY(edit::color_ranges(mesh, colors, context));
  }
  events.note(
      {NoteId::data_left_out, fmt::format("{}: {} has no materials, so the output lacks those of {}{}", label,
                                          mesh_io::mesh_format_info(format).name, counted(count, "mesh", "meshes"),
                                          to_vertices ? "; the vertices have their colors" : "")});
  return {};
}

// Returns the name of the file without its extension.
std::string stem_of_mesh(const std::string& input) {
  return std::filesystem::path(files::input_label(input)).filename().stem().string();
}

// Moves the meshes of the file to `source`, each as a surface.
Result<void> take_parts(MeshFile& file, const std::string& stem, const Context& context, Source& source) {
  for (std::size_t i = 0; i < file.parts.size(); ++i) {
    const MeshPart& part = file.parts[i];
    auto mesh = TRY(mesh::copy_part(file.mesh, part, mesh::PartData::attributes, context));
    mesh.material = part.material;
    mesh.name = part.name.empty() ? fmt::format("{} {}", stem, i + 1) : part.name;
    source.meshes.push_back(std::move(mesh));
    source.isos.push_back({IsoChoice::file_meshes(), FileMesh{i + 1}, {}});
  }
  return {};
}

void take_whole(MeshFile& file, const std::string& stem, Source& source) {
  const MeshPart* const only = file.parts.size() == 1 ? &file.parts.front() : nullptr;
  file.mesh.name = only != nullptr && !only->name.empty() ? only->name : stem;
  if (only != nullptr) file.mesh.material = only->material;
  source.meshes.push_back(std::move(file.mesh));
  source.isos.push_back({IsoChoice::file_meshes(), kWholeFile, {}});
}

}  // namespace

Result<Source> open_mesh_source(const SourceOptions& options, const SourceUse& use, const Context& context,
                                Events& events) {
  const Stopwatch watch;
  context.progress().begin("reading the mesh", 0);
  auto file = TRY(mesh_io::read_mesh(options.input, context, {.scene = true}));
  for (const Note& note : file.notes) events.note(note);
  Source source;
  source.of_meshes = true;
  source.label = printable(files::input_label(options.input));
  source.empty = file.mesh.triangles.empty();
  events.end(report_of_reading(file, options.input, source.label, watch.elapsed()));
  TRY(context.check());

  const auto record = parse_placement_record(file.placement);
  source.mesh_kinds = kinds_of(file.mesh, file.is_by_isoextract, file.placement);
  source.field = frame_of(file, source.label, record);
  const auto placed = TRY(place_mesh(source.field, options.placement, file.mesh));
  source.placement = placed.placement;
  source.output_from_index = placed.output_from_index;
  PlacedField told = placed;
  told.output_from_index = placed.placement.output_from_world();  // the file's coordinates are the only indices
  events.end(report_of_placing(told, source.field));
  if (use.is_in_meters) tell_other_unit(options.placement, source.field, source.label, events);
  source.from_world = placed_again(record.value_or(default_placement(file.y_up)), source.placement);
  source.clip = half_spaces_of(source.field, source.output_from_index, options.placement.space, options.clip);
  move_mesh(file.mesh, told.output_from_index, source.mesh_kinds);
  TRY(adapt_colors(file, use.mesh_format, context, file.mesh));
  TRY(adapt_materials(file, use.mesh_format, source.label, context, events, file.mesh));

  const std::string stem = stem_of_mesh(options.input);
  if (file.parts.size() > 1 && use.meshes_apart) {
    TRY(take_parts(file, stem, context, source));
    return source;
  }
  if (file.parts.size() > 1) {
    events.note({NoteId::data_left_out,
                 fmt::format("{}: the {} meshes of the file become one, without their names, because the output holds "
                             "one mesh",
                             source.label, file.parts.size())});
  }
  take_whole(file, stem, source);
  return source;
}

std::vector<std::filesystem::path> list_mesh_files(const std::filesystem::path& input, const Context& context) {
  std::vector<std::filesystem::path> files{input};
  for (const std::string& data : mesh_io::external_buffer_names(input, context)) {
    files.push_back(input.parent_path() / data);
  }
  return files;
}

}  // namespace isoextract::convert
