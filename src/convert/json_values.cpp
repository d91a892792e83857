#include "convert/json_values.hpp"

#include "base/printable_json.hpp"

namespace isoextract::convert {
namespace {

// Returns one kind for each exit code.
std::string_view kind_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::usage:
    case ErrorCode::placement: return "usage";
    case ErrorCode::input:
    case ErrorCode::empty_grid:
    case ErrorCode::no_surface:
    case ErrorCode::out_of_memory: return "input";
    case ErrorCode::unavailable: return "unavailable";
    case ErrorCode::output: return "output";
    case ErrorCode::frames: return "frames";
    case ErrorCode::verification: return "verification";
    case ErrorCode::cancelled: break;
  }
  return "cancelled";
}

// Returns a word that tells apart error codes of one kind, or null.
Json reason_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::empty_grid: return "empty_grid";
    case ErrorCode::no_surface: return "no_surface";
    case ErrorCode::out_of_memory: return "out_of_memory";
    default: return nullptr;
  }
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

Json json_of(const Error& error, const std::string& hint) {
  return {{"kind", kind_of(error.code)},
          {"exit_code", exit_code_of(error.code)},
          {"reason", reason_of(error.code)},
          {"message", error.message},
          {"hint", hint}};
}

Json json_of_notes(const Notes& notes) {
  Json json = Json::array();
  for (const Note& note : notes) json.push_back({{"id", word_of(note.id)}, {"text", note.text}});
  return json;
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
