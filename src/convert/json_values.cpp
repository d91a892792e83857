#include "convert/json_values.hpp"

#include "base/printable_json.hpp"

namespace isoextract::convert {
namespace {

std::string_view name_of(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::usage: return "usage";
    case ErrorKind::input: return "input";
    case ErrorKind::unavailable: return "unavailable";
    case ErrorKind::output: return "output";
    case ErrorKind::frames: return "frames";
    case ErrorKind::verification: return "verification";
    case ErrorKind::cancelled: break;
  }
  return "cancelled";
}

Json reason_name(Reason reason) {
  switch (reason) {
    case Reason::empty_grid: return "empty_grid";
    case Reason::no_surface: return "no_surface";
    case Reason::other: break;
  }
  return nullptr;
}

}  // namespace

std::string_view kind_name(field::FieldKind kind) {
  return kind == field::FieldKind::level_set ? "level set" : "density";
}

Json json_of(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

Json json_of(const field::Box& box) { return {{"min", json_of(box.min)}, {"max", json_of(box.max)}}; }

Json json_of(const field::IndexBox& box) {
  if (box.empty()) return nullptr;
  return {{"min", {box.min.x, box.min.y, box.min.z}}, {"max", {box.max.x, box.max.y, box.max.z}}};
}

Json json_of(const field::Affine& map) {
  Json rows = Json::array();
  const glm::dmat3& m = map.linear;
  for (int row = 0; row < 3; ++row) rows.push_back({m[0][row], m[1][row], m[2][row], map.offset[row]});
  return rows;
}

Json json_of(const Error& error) {
  return {{"kind", name_of(error.kind)},
          {"exit_code", static_cast<int>(error.kind)},
          {"reason", reason_name(error.reason)},
          {"message", error.message},
          {"hint", error.hint.text}};
}

Json json_of(const StageTime& time) { return {{"wall_seconds", time.wall_seconds}, {"cpu_seconds", time.cpu_seconds}}; }

Json json_of(const mesh::Topology& topology, const mesh::MeshSize& size) {
  const bool closed = topology.is_closed_oriented_manifold();
  return {{"closed", closed},
          {"open_edges", topology.open_edges},
          {"nonmanifold_edges", topology.nonmanifold_edges},
          {"misoriented_edges", topology.misoriented_edges},
          {"nonmanifold_vertices", topology.nonmanifold_vertices},
          {"components", topology.components},
          {"genus", closed ? Json(topology.genus()) : Json(nullptr)},
          {"area", size.area},
          {"volume", closed ? Json(size.volume) : Json(nullptr)},
          {"zero_area_triangles", size.zero_area_triangles}};
}

std::string json_text(const Json& document) {
  return printable_json(document.dump(2, ' ', false, Json::error_handler_t::replace)) + "\n";
}

std::string json_line(const Json& document) {
  return printable_json(document.dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace isoextract::convert
