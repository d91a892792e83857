// `isoextract compare`: prints the properties of two meshes and their distances to stdout, as text or JSON.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "accuracy/attribute_match.hpp"
#include "accuracy/mesh_distance.hpp"
#include "base/byte_size.hpp"
#include "base/context.hpp"
#include "base/machine.hpp"
#include "base/number_text.hpp"
#include "base/printable.hpp"
#include "base/stopwatch.hpp"
#include "cli/attribute_text.hpp"
#include "cli/layout.hpp"
#include "cli/planned_command.hpp"
#include "cli/progress_bar.hpp"
#include "cli/wrong_file_kind.hpp"
#include "convert/json_documents.hpp"
#include "convert/json_values.hpp"
#include "convert/placement_record.hpp"
#include "mesh/metrics.hpp"
#include "mesh/topology.hpp"
#include "mesh_io/mesh_reader.hpp"

namespace isoextract::cli {
namespace {

constexpr double kRoundings = 2;  // coordinates are rounded in the file and again in the world

struct Side {
  std::string path;
  mesh_io::MeshFile file;
  convert::ResolvedPlacement placement;  // from the file, or the default of its format
  std::optional<std::string>
      undone;           // the parts of the placement undone to reach the world; unset if the mesh is unchanged
  double rounding = 0;  // of its coordinates, if a mesh was transformed to the world
  mesh::Topology topology;
  mesh::MeshSize size;
  mesh::Bounds bounds;
};

Result<Side> read_side(const std::string& path, const Context& context) {
  auto file = mesh_io::read_mesh(path, context);
  if (!file) return tl::unexpected(add_mesh_file_hint(std::move(file.error()), path));
  Side side;
  side.path = path;
  side.file = std::move(*file);
  side.file.mesh.name = path;
  return side;
}

Result<void> measure_side(Side& side, const Context& context) {
  side.topology = TRY(mesh::measure_topology(side.file.mesh, context));
  side.size = mesh::measure_size(side.file.mesh);
  side.bounds = mesh::measure_bounds(side.file.mesh);
  return {};
}

using Placements = std::array<convert::ResolvedPlacement, 2>;
using Moves = std::array<field::Affine, 2>;

// Returns the placement of `mine`, which another program wrote, on the assumption that it was made from `other`, which
// isoextract wrote with the placement `of_other`. `up` is the up axis of the mesh that is not glTF; it overrides the
// record of `other`. Fails with ErrorCode::usage if `other` was turned to another axis.
Result<convert::ResolvedPlacement> placement_from(const Side& mine, const Side& other,
                                                  const convert::ResolvedPlacement& of_other,
                                                  const std::optional<convert::UpAxis>& up) {
  if (mine.file.y_up == other.file.y_up) return of_other;
  convert::ResolvedPlacement origin = of_other;
  convert::Placement& of_origin = origin.placement;
  if (!mine.file.y_up) return convert::placed_like(origin, up.value_or(of_origin.up));
  if (up && (of_origin.turn_z_up_to_y_up || of_origin.turn_y_up_to_z_up)) {
    if (convert::output_up(of_origin) != *up) {
      return fail(ErrorCode::usage,
                  fmt::format("{}: --up {} contradicts the placement that the file records ({})", other.path,
                              word_of(*up), convert::placement_text(of_other)),
                  "leave --up out");
    }
  } else if (up) {
    of_origin.up = *up;
  }
  return convert::placed_like(origin, convert::UpAxis::y);
}

// Returns the placements of both meshes. A file of isoextract without a placement has the default of its format: glTF
// is turned unless its world is y up, other formats are unchanged. A file of another program is assumed to be made from
// the other mesh, because other programs do not keep the placement that isoextract stores.
Result<Placements> placements_of(const std::array<Side, 2>& sides, const std::optional<convert::UpAxis>& up) {
  Placements placements;
  for (std::size_t i = 0; i < 2; ++i) {
    placements[i] = convert::parse_placement_record(sides[i].file.placement)
                        .value_or(convert::default_placement(sides[i].file.y_up, up.value_or(convert::UpAxis::z)));
  }
  for (std::size_t i = 0; i < 2 && sides[0].file.is_by_isoextract != sides[1].file.is_by_isoextract; ++i) {
    if (sides[i].file.is_by_isoextract) continue;
    placements[i] = TRY(placement_from(sides[i], sides[1 - i], placements[1 - i], up));
  }
  return placements;
}

bool are_alike(const Placements& placements) {
  return placements[0].output_from_world() == placements[1].output_from_world();
}

// Returns how each mesh moves: not at all if both have equal placements, otherwise to the world of its source.
Moves moves_of(const Placements& placements) {
  if (are_alike(placements)) return {};
  return {placements[0].output_from_world().inverse(), placements[1].output_from_world().inverse()};
}

// Returns whether --up y or --up z moves the meshes differently than no --up.
bool depends_on_up(const std::array<Side, 2>& sides) {
  const auto moves = [&](const std::optional<convert::UpAxis>& up) -> std::optional<Moves> {
    const auto placements = placements_of(sides, up);
    return placements ? std::optional(moves_of(*placements)) : std::nullopt;
  };
  const auto usual = moves(std::nullopt);
  return moves(convert::UpAxis::y) != usual || moves(convert::UpAxis::z) != usual;
}

// Leaves meshes with equal placements unchanged, and transforms others to the world of their source.
Result<void> bring_into_one_frame(std::array<Side, 2>& sides, const std::optional<convert::UpAxis>& up,
                                  const Messages& messages) {
  for (const Side& side : sides) {
    if (side.file.placement.empty() || convert::parse_placement_record(side.file.placement)) continue;
    messages.note(
        {NoteId::placement_unknown,
         fmt::format("{}: the file has no readable placement record, so compare assumes the default placement",
                     side.path)});
  }
  const auto placements = TRY(placements_of(sides, up));
  for (std::size_t i = 0; i < 2; ++i) sides[i].placement = placements[i];
  if (placements[0].placement.space != placements[1].placement.space) {
    const bool first = placements[0].placement.space == convert::Space::index;
    messages.note({NoteId::placement_differs,
                   fmt::format("{} is in voxel coordinates, and {} is in world coordinates: the distances compare "
                               "the numbers in the files",
                               sides[first ? 0 : 1].path, sides[first ? 1 : 0].path)});
    return {};
  }
  const bool alike = are_alike(placements);
  if (up && !depends_on_up(sides)) {
    const std::string_view why = sides[0].file.y_up && sides[1].file.y_up && alike ? "both meshes are glTF with y up"
                                 : sides[0].file.y_up || sides[1].file.y_up        ? "the glTF file states its turn"
                                                                                   : "neither mesh is glTF";
    messages.note({NoteId::no_effect, fmt::format("--up changes nothing: {}", why)});
  }
  if (alike) return {};
  for (Side& side : sides) {
    const field::Affine map = side.placement.output_from_world();
    side.rounding = accuracy::coordinate_rounding(side.file.mesh) / std::cbrt(std::abs(map.determinant()));
    if (map == field::Affine()) continue;
    const auto kinds = convert::kinds_of(side.file.mesh, side.file.is_by_isoextract, side.file.placement);
    convert::move_mesh(side.file.mesh, map.inverse(), kinds);
    side.undone = convert::placement_text(side.placement);
  }
  return {};
}

// Returns "no: 12 open edges, 3 vertices where surfaces touch", or "yes" with the genus.
std::string closed_text(const mesh::Topology& topology) {
  if (topology.is_closed_oriented_manifold()) return fmt::format("yes; genus {}", topology.genus());
  std::string text = "no";
  const char* before = ": ";
  const auto add = [&](std::uint64_t count, std::string_view what) {
    if (count == 0) return;
    text += fmt::format("{}{} {}", before, count, what);
    before = ", ";
  };
  add(topology.open_edges, "open edges");
  add(topology.nonmanifold_edges, "edges with more than two triangles");
  add(topology.misoriented_edges, "edges with opposite winding of the triangles");
  add(topology.nonmanifold_vertices, "vertices where surfaces touch");
  add(topology.repeated_index_triangles, "triangles that repeat a vertex");
  return text;
}

void add_side(NamedLines& lines, const Side& side) {
  lines.plain(printable(side.path));
  lines.add("format", side.file.format);
  if (side.undone) lines.add("undone", *side.undone);
  lines.add("vertices", fmt::format("{}", side.file.mesh.positions.size()));
  lines.add("triangles", side.size.zero_area_triangles == 0
                             ? fmt::format("{}", side.file.mesh.triangles.size())
                             : fmt::format("{}, {} of them without area", side.file.mesh.triangles.size(),
                                           side.size.zero_area_triangles));
  lines.add("components", fmt::format("{}", side.topology.components));
  lines.add("closed", closed_text(side.topology));
  lines.add("area", fmt::format("{:.9g}", side.size.area));
  if (side.topology.is_closed_oriented_manifold()) lines.add("volume", fmt::format("{:.9g}", side.size.volume));
  lines.add("bounds", fmt::format("{} .. {}", point_text(side.bounds.min, 9), point_text(side.bounds.max, 9)));
  lines.plain("");
}

std::string interval_text(double lower, double upper) { return fmt::format("{:.6g} to {:.6g}", lower, upper); }

void add_direction(NamedLines& lines, std::string_view name, const accuracy::DirectedDistance& distance) {
  lines.add(name, fmt::format("max {}, rms {:.6g}, mean {:.6g}, 99 % {:.6g}",
                              interval_text(distance.max_lower, distance.max_upper), distance.rms, distance.mean,
                              distance.percentile99));
  lines.add("", fmt::format("farthest at {}", point_text(distance.place, 9)));
}

std::string text_of(const std::array<Side, 2>& sides, const accuracy::MeshDistance& distance,
                    const accuracy::AttributeMatches& attributes) {
  NamedLines lines;
  for (const Side& side : sides) add_side(lines, side);
  const bool moved = sides[0].undone || sides[1].undone;
  lines.plain(moved ? "distances, in the unit of the meshes' source world" : "distances, in the unit of the meshes");
  add_direction(lines, "first to second", distance.a_to_b);
  add_direction(lines, "second to first", distance.b_to_a);
  lines.add("Hausdorff", interval_text(distance.hausdorff_lower, distance.hausdorff_upper));
  lines.add("rms", fmt::format("{:.6g}", distance.rms));
  lines.add("mean", fmt::format("{:.6g}", distance.mean));
  lines.add("99 %", fmt::format("{:.6g}", distance.percentile99));
  add_attributes(lines, attributes);
  return lines.take();
}

convert::Json side_json(const Side& side) {
  convert::Json json{{"file", side.path},
                     {"format", side.file.format},
                     {"undone", convert::optional_json(side.undone)},
                     {"vertices", side.file.mesh.positions.size()},
                     {"triangles", side.file.mesh.triangles.size()}};
  json.update(convert::json_of(side.topology, side.size));
  json["bounds"] = convert::json_of(field::Box{side.bounds.min, side.bounds.max});
  return json;
}

convert::Json direction_json(const accuracy::DirectedDistance& distance) {
  return {{"max", {distance.max_lower, distance.max_upper}},
          {"place", convert::json_of(distance.place)},
          {"nearest", convert::json_of(distance.nearest)},
          {"rms", distance.rms},
          {"mean", distance.mean},
          {"percentile99", distance.percentile99}};
}

convert::Json comparison_json(const std::array<Side, 2>& sides, const accuracy::MeshDistance& distance,
                              const accuracy::AttributeMatches& attributes) {
  return {{"schema", word_of(convert::JsonDocument::compare)},
          {"a", side_json(sides[0])},
          {"b", side_json(sides[1])},
          {"a_to_b", direction_json(distance.a_to_b)},
          {"b_to_a", direction_json(distance.b_to_a)},
          {"hausdorff", {distance.hausdorff_lower, distance.hausdorff_upper}},
          {"rms", distance.rms},
          {"mean", distance.mean},
          {"percentile99", distance.percentile99},
          {"resolution", distance.resolution},
          {"attributes", attributes_json(attributes)}};
}

// Computes narrower bounds of the greatest distance if its upper bound exceeds the limit.
void look_closer(const std::array<Side, 2>& sides, double limit, accuracy::DistanceOptions options,
                 accuracy::MeshDistance& distance, const Context& context) {
  if (distance.hausdorff_upper <= limit) return;
  options.tolerance = 1e-4;
  options.enough = limit;
  options.samples = 0;
  const auto closer = accuracy::measure_distance(sides[0].file.mesh, sides[1].file.mesh, options, context);
  if (!closer) return;
  const auto narrow = [](accuracy::DirectedDistance& wide, const accuracy::DirectedDistance& found) {
    wide.max_upper = std::min(wide.max_upper, found.max_upper);
    if (found.max_lower <= wide.max_lower) return;
    wide.max_lower = found.max_lower;
    wide.place = found.place;
    wide.nearest = found.nearest;
  };
  narrow(distance.a_to_b, closer->a_to_b);
  narrow(distance.b_to_a, closer->b_to_a);
  distance.hausdorff_lower = std::max(distance.a_to_b.max_lower, distance.b_to_a.max_lower);
  distance.hausdorff_upper = std::max(distance.a_to_b.max_upper, distance.b_to_a.max_upper);
}

// Adds a hint on the likely cause if isoextract wrote one of the meshes without triangles.
Error measuring_failed(Error error, const std::array<Side, 2>& sides) {
  for (const Side& side : sides) {
    if (!side.file.mesh.triangles.empty() || !side.file.is_by_isoextract || !error.hint.empty()) continue;
    error.hint =
        "'isoextract info' shows the range of the data; a surface is empty if the iso value lies outside this range";
  }
  return error;
}

Result<void> check_distance(const ComparePlan& plan, const std::array<Side, 2>& sides,
                            const accuracy::MeshDistance& distance) {
  // This form of the comparison makes NaN fail.
  const bool known = distance.hausdorff_lower <= distance.hausdorff_upper;
  if (!plan.max_distance || (known && distance.hausdorff_upper <= *plan.max_distance)) return {};
  const bool surely = distance.hausdorff_lower > *plan.max_distance;
  const auto turned = std::ranges::find_if(sides, [&](const Side& side) {
    return !plan.up && side.undone && side.file.placement.empty() && side.placement.placement.turn_z_up_to_y_up;
  });
  const std::string hint =
      turned == sides.end() ? ""
                            : fmt::format("compare turned {} from y up to z up; --up y compares it without this turn",
                                          printable(turned->path));
  return fail(ErrorCode::verification,
              fmt::format("{} and {}: the Hausdorff distance is {} {:.6g}, and --max-distance is {}", plan.meshes[0],
                          plan.meshes[1], surely ? "at least" : "possibly as large as",
                          surely ? distance.hausdorff_lower : distance.hausdorff_upper, *plan.max_distance),
              hint);
}

// Fails with ErrorCode::verification, after the report, if the meshes may be farther apart than --max-distance.
Result<void> run_compare(const ComparePlan& plan, const Messages& messages) {
  const Stopwatch watch;
  const Context context{plan.memory};
  std::array<Side, 2> sides;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    {
      const ProgressBar bar(context.progress(), messages.verbosity() != Verbosity::quiet);
      context.progress().begin("reading meshes", 0);
      sides[i] = TRY(read_side(plan.meshes[i], context));
    }
    // Prints notes before the next step: data that the reader left out can make this step fail.
    for (const Note& note : sides[i].file.notes) messages.note(note);
  }
  TRY(bring_into_one_frame(sides, plan.up, messages));
  accuracy::MeshDistance distance;
  {
    const ProgressBar bar(context.progress(), messages.verbosity() != Verbosity::quiet);
    context.progress().begin("measuring meshes", 0);
    for (Side& side : sides) {
      TRY(measure_side(side, context));
    }
    const accuracy::DistanceOptions options;
    auto measured = accuracy::measure_distance(sides[0].file.mesh, sides[1].file.mesh, options, context);
    if (!measured) return tl::unexpected(measuring_failed(std::move(measured.error()), sides));
    distance = *measured;
    if (plan.max_distance && distance.hausdorff_lower <= *plan.max_distance) {
      look_closer(sides, *plan.max_distance, options, distance, context);
    }
  }
  messages.detail(fmt::format("compared in {:.2f} s, peak memory {}", watch.elapsed().wall_seconds,
                              format_byte_size(peak_memory())));
  // glTF stores colors as linear light, other formats as sRGB.
  const accuracy::AttributeMatches attributes =
      accuracy::match_attributes(sides[0].file.mesh, sides[1].file.mesh, sides[0].file.y_up == sides[1].file.y_up,
                                 kRoundings * (sides[0].rounding + sides[1].rounding));
  const std::string text = plan.json ? convert::json_text(comparison_json(sides, distance, attributes))
                                     : text_of(sides, distance, attributes);
  TRY(print_to_stdout(text));
  return check_distance(plan, sides, distance);
}

}  // namespace

std::unique_ptr<Command> make_compare_command() {
  return std::make_unique<PlannedCommand<CompareFlags, plan_compare, run_compare>>(
      CommandWords{"compare", "MESH MESH [options]", "Measure how far two meshes are apart."});
}

}  // namespace isoextract::cli
