#include "convert/placement_record.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/finite.hpp"
#include "base/number_text.hpp"
#include "base/parallel.hpp"
#include "convert/json_values.hpp"

namespace isoextract::convert {
namespace {

constexpr std::string_view kZToY = "z up to y up";
constexpr std::string_view kYToZ = "y up to z up";
constexpr std::array<std::string_view, 4> kMirrored{"", "x", "y", "xy"};

std::string_view turn_text(const Placement& placement) {
  return placement.turn_z_up_to_y_up ? kZToY : placement.turn_y_up_to_z_up ? kYToZ : "";
}

// Reads the text under `key`, which stays unchanged if the key is missing. Returns false if the value is not text.
bool read_text(const Json& json, const char* key, std::string& text) {
  const auto found = json.find(key);
  if (found == json.end()) return true;
  if (!found->is_string()) return false;
  text = found->get<std::string>();
  return true;
}

template <class E>
bool read_word(const Json& json, const char* key, std::optional<E>& value) {
  std::string text;
  if (!read_text(json, key, text)) return false;
  if (text.empty()) return true;
  for (const Word<E>& entry : words_of(E{})) {
    if (entry.word == text) value = entry.value;
  }
  return value.has_value();
}

bool read_scale(const Json& json, double& scale) {
  const auto found = json.find("scale");
  if (found == json.end()) return true;
  if (!found->is_number()) return false;
  scale = found->get<double>();
  return std::isfinite(scale) && scale > 0;
}

bool read_vector(const Json& json, const char* key, std::optional<glm::dvec3>& vector) {
  const auto found = json.find(key);
  if (found == json.end()) return true;
  if (!found->is_array() || found->size() != 3) return false;
  vector.emplace();
  for (int axis = 0; axis < 3; ++axis) {
    const Json& number = (*found)[static_cast<std::size_t>(axis)];
    if (!number.is_number()) return false;
    (*vector)[axis] = number.get<double>();
  }
  return is_finite(*vector);
}

bool is_known_unit(const std::string& name) {
  const auto unit = find_length_unit(name);
  return name.empty() || (unit && unit->name == name);
}

// Returns whether the values are far enough from the limits of double that undoing the placement stays finite.
bool can_be_undone(const ResolvedPlacement& record) {
  constexpr double kMost = 1e30;
  return record.placement.scale > 1 / kMost && record.placement.scale < kMost && glm::length(record.moved_by) < kMost;
}

// Returns the ratio of the two units, which are known or empty; 1 if they are empty.
double scale_of_units(const Placement& placement) {
  const auto from = find_length_unit(placement.unit);
  const auto to = find_length_unit(placement.to_unit);
  return from && to ? unit_ratio(*from, *to) : 1;
}

glm::dmat3 up_axis_turn(const Placement& placement) {
  ResolvedPlacement turned;
  turned.placement.turn_z_up_to_y_up = placement.turn_z_up_to_y_up;
  turned.placement.turn_y_up_to_z_up = placement.turn_y_up_to_z_up;
  return turned.output_from_world().linear;
}

}  // namespace

ResolvedPlacement default_placement(bool format_is_y_up, UpAxis up) {
  ResolvedPlacement record;
  record.placement.up = up;
  record.placement.turn_z_up_to_y_up = format_is_y_up && up == UpAxis::z;
  return record;
}

std::string write_placement_record(const ResolvedPlacement& resolved, mesh_io::MeshFormat format,
                                   const std::vector<NamedKind>& attributes) {
  const Placement& placement = resolved.placement;
  const std::string kinds = kinds_text(attributes);
  const std::string end = kinds.empty() ? "}" : fmt::format(R"(,"attributes":{}}})", kinds);
  // Built as text: JSON documents of the library leak memory if allocating a member fails.
  if (placement.space == Space::index) return fmt::format(R"({{"space":"{}"{})", word_of(Space::index), end);
  if (kinds.empty() && resolved == default_placement(mesh_io::is_gltf(format))) return {};
  // The header of STL has 80 bytes, so STL leaves out what follows from the other values.
  const bool is_short = format == mesh_io::MeshFormat::stl;
  const std::string_view turned = turn_text(placement);
  std::string text = is_short && !turned.empty() ? "" : fmt::format(R"("up":"{}")", word_of(placement.up));
  if (!turned.empty()) text += fmt::format(R"({}"turned":"{}")", text.empty() ? "" : ",", turned);
  if (placement.to_space) {
    text += fmt::format(R"(,"to_space":"{}","mirrored":"{}{}")", word_of(*placement.to_space),
                        resolved.signs.x < 0 ? "x" : "", resolved.signs.y < 0 ? "y" : "");
  }
  const bool by_units = !placement.unit.empty() && placement.scale == scale_of_units(placement);
  if (placement.scale != 1 && !(is_short && by_units)) text += fmt::format(R"(,"scale":{})", placement.scale);
  if (!placement.unit.empty()) text += fmt::format(R"(,"unit":"{}","to_unit":"{}")", placement.unit, placement.to_unit);
  if (placement.center) {
    const glm::dvec3& by = resolved.moved_by;
    text += fmt::format(R"(,"moved_by":[{},{},{}])", by.x, by.y, by.z);
  }
  return "{" + text + end;
}

std::optional<ResolvedPlacement> parse_placement_record(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return std::nullopt;
  ResolvedPlacement record;
  Placement& placement = record.placement;
  std::optional<Space> space;
  if (!read_word(json, "space", space)) return std::nullopt;
  placement.space = space.value_or(Space::world);
  if (placement.space == Space::index) return record;
  std::optional<UpAxis> up;
  std::optional<glm::dvec3> moved_by;
  std::string turned;
  std::string mirrored;
  const bool readable = read_word(json, "up", up) && read_text(json, "turned", turned) &&
                        read_word(json, "to_space", placement.to_space) && read_scale(json, placement.scale) &&
                        read_text(json, "unit", placement.unit) && read_text(json, "to_unit", placement.to_unit) &&
                        read_vector(json, "moved_by", moved_by) && read_text(json, "mirrored", mirrored);
  const bool known = (turned.empty() || turned == kZToY || turned == kYToZ) &&
                     std::ranges::find(kMirrored, mirrored) != kMirrored.end() &&
                     (placement.to_space || mirrored.empty()) && placement.unit.empty() == placement.to_unit.empty();
  if (!up && !turned.empty()) up = turned == kZToY ? UpAxis::z : UpAxis::y;
  if (!readable || !up || !known || !is_known_unit(placement.unit) || !is_known_unit(placement.to_unit)) {
    return std::nullopt;
  }
  if (!json.contains("scale")) placement.scale = scale_of_units(placement);
  placement.up = *up;
  placement.turn_z_up_to_y_up = turned == kZToY;
  placement.turn_y_up_to_z_up = turned == kYToZ;
  placement.center = moved_by.has_value();
  record.moved_by = moved_by.value_or(glm::dvec3(0));
  record.signs = {mirrored.starts_with('x') ? -1 : 1, mirrored.ends_with('y') ? -1 : 1};
  if (!can_be_undone(record)) return std::nullopt;
  return record;
}

UpAxis output_up(const Placement& placement) {
  if (placement.turn_z_up_to_y_up) return UpAxis::y;
  return placement.turn_y_up_to_z_up ? UpAxis::z : placement.up;
}

ResolvedPlacement placed_like(const ResolvedPlacement& other, UpAxis up) {
  ResolvedPlacement placed = other;
  placed.placement.turn_z_up_to_y_up = other.placement.up == UpAxis::z && up == UpAxis::y;
  placed.placement.turn_y_up_to_z_up = other.placement.up == UpAxis::y && up == UpAxis::z;
  placed.moved_by = up_axis_turn(placed.placement) * (glm::inverse(up_axis_turn(other.placement)) * other.moved_by);
  return placed;
}

ResolvedPlacement placed_again(const ResolvedPlacement& before, const ResolvedPlacement& again) {
  const field::Affine map = again.output_from_world();
  if (before.placement.space == Space::index) return map == field::Affine() ? before : again;
  ResolvedPlacement placed = placed_like(before, output_up(again.placement));
  placed.moved_by = map(before.moved_by);
  placed.placement.center = placed.moved_by != glm::dvec3(0);
  placed.placement.scale *= again.placement.scale;
  if (again.placement.to_unit.empty()) return placed;
  if (placed.placement.unit.empty()) placed.placement.unit = again.placement.unit;
  placed.placement.to_unit = again.placement.to_unit;
  return placed;
}

std::string placement_text(const ResolvedPlacement& resolved) {
  const Placement& placement = resolved.placement;
  if (placement.space == Space::index) return "voxel coordinates";
  std::vector<std::string> parts;
  if (placement.to_space) parts.push_back(fmt::format("in {}", word_of(*placement.to_space)));
  if (const std::string_view turned = turn_text(placement); !turned.empty()) {
    parts.push_back(fmt::format("turned from {}", turned));
  }
  if (placement.unit != placement.to_unit) {
    parts.push_back(fmt::format("scaled by {} ({} to {})", placement.scale, placement.unit, placement.to_unit));
  } else {
    if (placement.scale != 1) parts.push_back(fmt::format("scaled by {}", placement.scale));
    if (!placement.unit.empty()) parts.push_back(fmt::format("in {}", placement.unit));
  }
  if (resolved.moved_by != glm::dvec3(0)) parts.push_back("moved by " + point_text(resolved.moved_by, 12));
  return fmt::format("{}", fmt::join(parts, ", "));
}

void move_mesh(mesh::Mesh& mesh, const field::Affine& map, const std::vector<NamedKind>& attributes) {
  if (map == field::Affine()) return;
  mesh.origin = map(mesh.origin);
  for_each_index(mesh.positions.size(),
                 [&](std::size_t v) { mesh.positions[v] = glm::vec3(map.linear * glm::dvec3(mesh.positions[v])); });
  transform_attributes(mesh, attributes, map);
  if (map.determinant() > 0) return;
  for (glm::uvec3& triangle : mesh.triangles) std::swap(triangle.y, triangle.z);
}

std::string world_text(const ResolvedPlacement& resolved) {
  const std::string done = placement_text(resolved);
  if (resolved.placement.space == Space::index) return done;
  return fmt::format("world coordinates{}{}", done.empty() ? "" : ", ", done);
}

std::string file_text(const ResolvedPlacement& resolved) {
  const std::string done = placement_text(resolved);
  return fmt::format("the file's coordinates{}{}", done.empty() ? "" : ", ", done);
}

}  // namespace isoextract::convert
