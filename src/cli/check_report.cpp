#include "cli/check_report.hpp"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/number_text.hpp"
#include "base/printable.hpp"
#include "cli/layout.hpp"
#include "convert/json_documents.hpp"
#include "convert/json_values.hpp"

namespace isoextract::cli {
namespace {

using check::BoundaryLoop;
using check::Component;
using check::MeshCheck;
using check::Requirement;
using check::Shell;
using convert::Json;

constexpr std::size_t kRowsOfText = 12;
constexpr std::size_t kRowsOfJson = 1000;

// Returns the indices of the `most` largest entries in descending order; equal entries keep their order.
template <class T, class Size>
std::vector<std::size_t> largest(const std::vector<T>& list, std::size_t most, const Size& size_of) {
  std::vector<std::size_t> order(list.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto last = order.begin() + static_cast<std::ptrdiff_t>(std::min(most, order.size()));
  std::ranges::partial_sort(order, last, [&](std::size_t a, std::size_t b) {
    return size_of(list[a]) != size_of(list[b]) ? size_of(list[a]) > size_of(list[b]) : a < b;
  });
  order.erase(last, order.end());
  return order;
}

std::vector<std::size_t> largest_components(const MeshCheck& check, std::size_t most) {
  return largest(check.components, most, [](const Component& component) { return component.triangles; });
}

std::vector<std::size_t> longest_loops(const MeshCheck& check, std::size_t most) {
  return largest(check.loops, most, [](const BoundaryLoop& loop) { return loop.length; });
}

// Returns "yes", or "no: 12 open edges in 2 loops".
std::string answer(Requirement requirement, const MeshCheck& check) {
  const auto why = check::unmet_reason(requirement, check);
  return why ? "no: " + *why : "yes";
}

// Returns "none", or "12 triangles without area".
std::string none_or(Requirement requirement, const MeshCheck& check) {
  return check::unmet_reason(requirement, check).value_or("none");
}

std::string point_in_words(const glm::dvec3& v) { return point_text(v, 9); }

std::string closed_line(const MeshCheck& check) {
  std::string text = answer(Requirement::closed, check);
  if (check.loops.empty()) return text;
  const BoundaryLoop& loop = check.loops[longest_loops(check, 1).front()];
  text += fmt::format("; the longest has {} edges and length {:.6g}", loop.edges, loop.length);
  if (check.welded) {
    const std::string welded = counted(check.repeated_vertices, "vertex", "vertices");
    text += check.welded->open_edges == 0 ? fmt::format("; closed after welding {} at equal positions", welded)
                                          : fmt::format("; {} after welding {} at equal positions",
                                                        counted(check.welded->open_edges, "open edge"), welded);
  }
  return text;
}

std::string intersection_line(const MeshCheck& check) {
  const auto& found = check.intersections;
  std::string text = none_or(Requirement::no_self_intersections, check);
  if (found.pairs == 0) return text;
  if (!found.at_least) {
    text += fmt::format(", {} in total", counted(found.triangles, "triangle"));
    if (found.in_one_plane > 0) text += fmt::format("; {} in one plane", counted(found.in_one_plane, "pair"));
    if (found.neighbors > 0) text += fmt::format("; {} of neighbors", counted(found.neighbors, "pair"));
  }
  const auto& [first, second] = found.examples.front();
  return text + fmt::format("; first pair: triangles {} and {}", first, second);
}

std::string components_line(const MeshCheck& check) {
  std::string text = fmt::format("{}", check.topology.components);
  const char* before = ": ";
  for (const Word<Shell>& shell : words_of(Shell{})) {
    if (const std::uint64_t count = check.count(shell.value); count > 0) {
      text += fmt::format("{}{} {}", before, count, shell.word);
      before = ", ";
    }
  }
  return text;
}

std::string normals_line(const MeshCheck& check) {
  if (!check.normals) return "none in the file";
  const auto& normals = *check.normals;
  std::string text = fmt::format("{} of {} corners point against their triangle ({:.3g} %)", normals.against,
                                 normals.corners, 100 * normals.flipped_fraction());
  if (normals.missing > 0) text += fmt::format("; {} have none", normals.missing);
  if (normals.not_unit > 0) text += fmt::format("; {} are not of length 1", normals.not_unit);
  return text;
}

void add_mesh(NamedLines& lines, const CheckReport& report, const MeshCheck& check) {
  lines.add("vertices", check.repeated_vertices == 0 ? fmt::format("{}", check.vertices)
                                                     : fmt::format("{}, {} of them at the position of another vertex",
                                                                   check.vertices, check.repeated_vertices));
  lines.add("triangles", fmt::format("{}", check.triangles));
  const glm::dvec3 size = check.bounds.max - check.bounds.min;
  lines.add("size", fmt::format("{:.6g} x {:.6g} x {:.6g}{}", size.x, size.y, size.z,
                                report.unit ? fmt::format(" {}", report.unit->name) : "; the file states no unit"));
  lines.add("bounds", fmt::format("{} .. {}", point_in_words(check.bounds.min), point_in_words(check.bounds.max)));
  lines.add("area",
            fmt::format("{:.9g}{}", check.size.area, report.unit ? fmt::format(" {}2", report.unit->name) : ""));
  if (check.has_volume()) {
    lines.add("volume",
              fmt::format("{:.9g}{}", check.size.volume, report.unit ? fmt::format(" {}3", report.unit->name) : ""));
  }
  if (check.topology.is_closed_oriented_manifold()) lines.add("genus", fmt::format("{}", check.topology.genus()));
  lines.add("components", components_line(check));
  lines.add("closed", closed_line(check));
  lines.add("manifold", answer(Requirement::manifold, check));
  lines.add("oriented", answer(Requirement::oriented, check));
  lines.add("outward", check.components.empty() || std::ranges::any_of(check.components, &Component::has_inside)
                           ? answer(Requirement::outward, check)
                           : "unknown: no component has an inside");
  lines.add("intersections", intersection_line(check));
  lines.add("zero area", none_or(Requirement::no_zero_area, check));
  lines.add("duplicates", none_or(Requirement::no_duplicates, check));
  lines.add("unused", none_or(Requirement::no_unused_vertices, check));
  if (report.has_normals) lines.add("normals", normals_line(check));
}

void add_components(NamedLines& lines, const MeshCheck& check) {
  if (check.components.size() < 2) return;
  lines.plain("");
  lines.plain(fmt::format("  {:>10} {:>10} {:>8} {:>12} {:>12} {:>6} {:>6}  {}", "component", "triangles", "holes",
                          "area", "volume", "genus", "within", "is"));
  const auto rows = largest_components(check, kRowsOfText);
  for (const std::size_t row : rows) {
    const Component& component = check.components[row];
    lines.plain(fmt::format("  {:>10} {:>10} {:>8} {:>12.6g} {:>12} {:>6} {:>6}  {}", row, component.triangles,
                            component.loops, component.area,
                            component.has_inside() ? fmt::format("{:.6g}", component.volume) : "-",
                            component.genus ? fmt::format("{}", *component.genus) : "-", component.enclosing_shells,
                            word_of(component.shell)));
  }
  if (check.components.size() > rows.size()) {
    lines.plain(fmt::format("  and {}", counted(check.components.size() - rows.size(), "smaller component")));
  }
}

std::string part_name(const PartReport& part, std::size_t number) {
  return part.name.empty() ? fmt::format("mesh {}", number) : printable(part.name, 60);
}

void add_parts(NamedLines& lines, const CheckReport& report) {
  const std::size_t shown = std::min(report.parts.size(), kRowsOfText);
  for (std::size_t i = 0; i < shown; ++i) {
    lines.plain("");
    lines.plain(part_name(report.parts[i], i));
    add_mesh(lines, report, report.parts[i].check);
  }
  if (shown < report.parts.size()) {
    lines.plain("");
    lines.plain(fmt::format("and {}, listed in the JSON report",
                            counted(report.parts.size() - shown, "more mesh", "more meshes")));
  }
}

Json edges_json(const check::EdgeDefects& edges) {
  return {{"open_edges", edges.open},
          {"nonmanifold_edges", edges.nonmanifold},
          {"misoriented_edges", edges.misoriented},
          {"nonmanifold_vertices", edges.nonmanifold_vertices}};
}

Json bounds_json(const mesh::Bounds& bounds) { return convert::json_of(field::Box{bounds.min, bounds.max}); }

Json component_json(const Component& component, std::size_t number) {
  Json json{{"component", number},
            {"shell", word_of(component.shell)},
            {"within", component.enclosing_shells},
            {"vertices", component.vertices},
            {"triangles", component.triangles}};
  json.update(edges_json(component.edges));
  json["loops"] = component.loops;
  json["genus"] = convert::optional_json(component.genus);
  json["area"] = component.area;
  json["volume"] = component.has_inside() ? Json(component.volume) : Json(nullptr);
  json["bounds"] = bounds_json(component.bounds);
  return json;
}

Json intersections_json(const mesh::SelfIntersections& found) {
  const auto counted = [&](std::uint64_t count) { return found.at_least ? Json(nullptr) : Json(count); };
  Json examples = Json::array();
  for (const auto& [first, second] : found.examples) examples.push_back({first, second});
  return {{"pairs", found.pairs},
          {"more", found.at_least},
          {"in_one_plane", counted(found.in_one_plane)},
          {"neighbors", counted(found.neighbors)},
          {"triangles", counted(found.triangles)},
          {"examples", std::move(examples)}};
}

Json normals_json(const std::optional<check::NormalFigures>& normals) {
  if (!normals) return nullptr;
  return {{"corners", normals->corners},
          {"against", normals->against},
          {"missing", normals->missing},
          {"not_unit", normals->not_unit}};
}

Json shells_json(const MeshCheck& check) {
  Json shells = Json::object();
  for (const Word<Shell>& shell : words_of(Shell{})) shells[std::string(shell.word)] = check.count(shell.value);
  return shells;
}

Json mesh_json(const MeshCheck& check) {
  const mesh::Topology& topology = check.topology;
  const bool closed = topology.is_closed_oriented_manifold();
  Json loops = Json::array();
  for (const std::size_t row : longest_loops(check, kRowsOfJson)) {
    const BoundaryLoop& loop = check.loops[row];
    loops.push_back({{"edges", loop.edges}, {"length", loop.length}, {"component", loop.component}});
  }
  Json components = Json::array();
  for (const std::size_t row : largest_components(check, kRowsOfJson)) {
    components.push_back(component_json(check.components[row], row));
  }
  Json joined = nullptr;
  if (check.welded) {
    joined = edges_json({check.welded->open_edges, check.welded->nonmanifold_edges, check.welded->misoriented_edges,
                         check.welded->nonmanifold_vertices});
    joined["components"] = check.welded->components;
  }
  Json json{{"vertices", check.vertices},
            {"triangles", check.triangles},
            {"closed", topology.open_edges == 0 && check.triangles > 0}};
  json.update(edges_json(
      {topology.open_edges, topology.nonmanifold_edges, topology.misoriented_edges, topology.nonmanifold_vertices}));
  json.update({{"loops", check.loops.size()},
               {"longest_loops", std::move(loops)},
               {"repeated_vertices", check.repeated_vertices},
               {"if_joined", std::move(joined)},
               {"unused_vertices", topology.unused_vertices},
               {"repeated_index_triangles", topology.repeated_index_triangles},
               {"zero_area_triangles", check.intersections.zero_area_triangles},
               {"duplicate_triangles", check.intersections.duplicate_triangles},
               {"self_intersections", intersections_json(check.intersections)},
               {"components", topology.components},
               {"shells", shells_json(check)},
               {"largest_components", std::move(components)},
               {"genus", closed ? Json(topology.genus()) : Json(nullptr)},
               {"area", check.size.area},
               {"volume", check.has_volume() ? Json(check.size.volume) : Json(nullptr)},
               {"bounds", bounds_json(check.bounds)},
               {"normals", normals_json(check.normals)}});
  return json;
}

Json required_json(const CheckReport& report) {
  Json required = Json::array();
  for (const Requirement one : report.required) {
    const auto why = unmet_reason(one, report);
    required.push_back({{"requirement", word_of(one)}, {"met", !why}, {"found", convert::optional_json(why)}});
  }
  return required;
}

}  // namespace

std::optional<std::string> unmet_reason(Requirement requirement, const CheckReport& report) {
  if (report.parts.empty()) return check::unmet_reason(requirement, report.whole);
  std::optional<std::string> first;
  std::uint64_t failing = 0;
  for (std::size_t i = 0; i < report.parts.size(); ++i) {
    const auto why = check::unmet_reason(requirement, report.parts[i].check);
    if (!why) continue;
    ++failing;
    if (!first) first = fmt::format("{} has {}", part_name(report.parts[i], i), *why);
  }
  if (failing > 1) *first += fmt::format("; {} of {} meshes fail", failing, report.parts.size());
  return first;
}

std::string check_text(const CheckReport& report) {
  NamedLines lines;
  lines.plain(printable(report.file));
  lines.add("format", report.format);
  if (!report.parts.empty())
    lines.add("meshes", fmt::format("{}; the figures below are for all meshes together", report.parts.size()));
  if (report.welded) lines.add("welded", "vertices at equal positions");
  add_mesh(lines, report, report.whole);
  add_components(lines, report.whole);
  add_parts(lines, report);
  lines.plain("");
  lines.plain("how slicers and game engines treat the mesh");
  for (const Finding& finding : findings_of(report)) lines.add(finding.who, finding.text);
  return lines.take();
}

Json check_json(const CheckReport& report) {
  Json parts = Json::array();
  for (const PartReport& part : report.parts) {
    Json json{{"name", part.name}};
    json.update(mesh_json(part.check));
    parts.push_back(std::move(json));
  }
  Json findings = Json::array();
  for (const Finding& finding : findings_of(report)) findings.push_back({{"who", finding.who}, {"text", finding.text}});
  return {{"schema", word_of(convert::JsonDocument::check)},
          {"file", report.file},
          {"format", report.format},
          {"unit", report.unit ? Json(report.unit->name) : Json(nullptr)},
          {"welded", report.welded},
          {"mesh", mesh_json(report.whole)},
          {"meshes", std::move(parts)},
          {"required", required_json(report)},
          {"findings", std::move(findings)}};
}

}  // namespace isoextract::cli
