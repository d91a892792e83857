#include "convert/conversion_report.hpp"

#include <filesystem>
#include <numeric>

#include "base/version.hpp"

namespace isoextract::convert {
namespace {

using convert::json_of;

template <class T>
Json optional_json(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json json_of(const ResolvedOptions& o) {
  return {{"method", o.method},
          {"iso", o.isos},
          {"normals", o.normals},
          {"nan", o.nan},
          {"empty", o.empty},
          {"cap", o.cap},
          {"roi", o.roi ? json_of(*o.roi) : Json(nullptr)},
          {"resolution", o.resolution ? Json{o.resolution->x, o.resolution->y, o.resolution->z} : Json(nullptr)},
          {"space", o.space},
          {"up", o.up},
          {"turned_to_y_up", o.turned_to_y_up},
          {"scale", o.scale},
          {"unit", o.unit.empty() ? Json(nullptr) : Json(o.unit)},
          {"format", o.format},
          {"ascii", o.ascii},
          {"simplify", o.simplify.empty() ? Json(nullptr) : Json(o.simplify)},
          {"error", o.error.empty() ? Json(nullptr) : Json(o.error)},
          {"verify", o.verify},
          {"memory_limit", o.memory_limit}};
}

Json json_of(const InputFacts& input) {
  Json json{{"path", input.path},       {"format", input.format},
            {"name", input.name},       {"file_bytes", optional_json(input.file_bytes)},
            {"sparse", input.sparse},   {"sample_type", field::sample_type_name(input.type)},
            {"samples", input.samples}, {"stored_bytes", input.stored_bytes},
            {"box", json_of(input.box)}};
  const glm::i64vec3 dims = input.box.empty() ? glm::i64vec3(0) : input.box.dims();
  json["dims"] = {dims.x, dims.y, dims.z};
  json["kind"] = kind_name(input.kind);
  json["inside"] = inside_name(input.kind);
  json["value_scale"] = {{"slope", input.scale.slope}, {"intercept", input.scale.intercept}};
  json["index_to_world"] = json_of(input.index_to_world);
  json["world_space"] = input.world_space;
  return json;
}

Json json_of(const StageRecord& stage) {
  Json json{{"stage", stage.stage}};
  if (stage.iso) json["iso"] = *stage.iso;
  json.update(json_of(stage.time));
  return json;
}

Json json_of(const WorkFact& fact) {
  Json json{{"what", fact.what}, {"done", fact.done}};
  if (fact.count) json["count"] = *fact.count;
  if (fact.total) json["total"] = *fact.total;
  json["text"] = fact.text;
  return json;
}

Json json_of(const MeshRecord& mesh) {
  Json json{{"iso", mesh.iso},
            {"file", mesh.file},
            {"name", mesh.name},
            {"vertices", mesh.vertices},
            {"triangles", mesh.triangles}};
  json.update(json_of(mesh.topology, mesh.size));
  json["euler"] = mesh.topology.euler;
  json["bounds"] = mesh.vertices == 0 ? Json(nullptr) : json_of(field::Box{mesh.bounds.min, mesh.bounds.max});
  json["origin"] = json_of(mesh.origin);
  if (mesh.error) json["error"] = *mesh.error;
  return json;
}

Json json_of(const SimplificationRecord& record) {
  const auto range = [](const DistanceRange& r) { return Json{{"lower", r.lower}, {"upper", r.upper}}; };
  return {{"iso", record.iso},
          {"asked", {{"distance", record.asked}, {"unit", record.asked_in_voxels ? "voxel" : "world"}}},
          {"measured", {{"voxels", range(record.voxels)}, {"world", range(record.world)}}},
          {"triangles_before", record.triangles_before},
          {"triangles_after", record.triangles_after},
          {"passes", record.passes},
          {"time", json_of(record.time)}};
}

Json json_of(const FileRecord& file) { return {{"path", file.path}, {"bytes", file.bytes}}; }

Json json_of(const ExtractionRecord& extraction);

template <class T>
Json array_of(const std::vector<T>& records) {
  Json array = Json::array();
  for (const T& record : records) array.push_back(json_of(record));
  return array;
}

Json json_of(const ExtractionRecord& extraction) {
  return {{"iso", extraction.iso}, {"triangles", extraction.triangles}, {"work", array_of(extraction.work)}};
}

}  // namespace

InputFacts input_facts(const std::string& path, const field::ScalarField& field) {
  InputFacts facts;
  facts.path = path;
  facts.format = field.format;
  facts.name = field.name;
  facts.world_space = field.world_space;
  facts.type = field.type();
  facts.kind = field.kind;
  facts.scale = field.scale;
  facts.index_to_world = field.index_to_world;
  facts.box = field.extents();
  const std::size_t size = field::sample_size(facts.type);
  if (const auto* dense = std::get_if<field::DenseSamples>(&field.samples)) {
    facts.samples = dense->count();
    facts.stored_bytes = dense->count() * size;
  } else {
    const auto& sparse = std::get<field::SparseSamples>(field.samples);
    constexpr std::size_t kBlockSamples =
        std::size_t{field::SparseBlock::kSize} * field::SparseBlock::kSize * field::SparseBlock::kSize;
    facts.sparse = true;
    facts.samples = sparse.active_voxels;
    facts.stored_bytes = sparse.blocks.size() * kBlockSamples * size;
  }
  std::error_code none;
  const std::uintmax_t file_bytes = std::filesystem::file_size(path, none);
  if (!none) facts.file_bytes = file_bytes;
  return facts;
}

MeshRecord mesh_record(double iso, const std::string& file, const mesh::Mesh& mesh) {
  return {iso,
          file,
          mesh.name,
          mesh.positions.size(),
          mesh.triangles.size(),
          mesh.origin,
          mesh::measure_bounds(mesh),
          mesh::measure_size(mesh),
          mesh::measure_topology(mesh),
          std::nullopt};
}

Json json_of(const ConversionReport& report) {
  Json json{{"schema_version", kReportSchemaVersion},
            {"program", {{"name", "isoextract"}, {"version", version()}}},
            {"status", report.error ? "failed" : "done"}};
  if (report.error) json["error"] = json_of(*report.error);
  json["arguments"] = report.arguments;
  json["options"] = json_of(report.options);
  json["device"] = {{"backend", report.backend}, {"name", report.device}, {"threads", report.threads}};
  json["input"] = report.input ? json_of(*report.input) : Json(nullptr);
  json["output_from_index"] = report.output_from_index ? json_of(*report.output_from_index) : Json(nullptr);
  json["region"] = report.region ? json_of(*report.region) : Json(nullptr);
  json["stages"] = array_of(report.stages);
  json["total"] = json_of(report.total);
  const std::uint64_t written = std::accumulate(report.files.begin(), report.files.end(), std::uint64_t{0},
                                                [](std::uint64_t sum, const FileRecord& f) { return sum + f.bytes; });
  json["bytes"] = {{"read", report.bytes_read}, {"written", written}, {"uploaded", report.bytes_uploaded}};
  json["peak_memory_bytes"] = report.peak_memory;
  json["work"] = array_of(report.work);
  json["extractions"] = array_of(report.extractions);
  if (report.options.verify) json["verification"] = array_of(report.verifications);
  json["simplifications"] = array_of(report.simplifications);
  json["meshes"] = array_of(report.meshes);
  json["files"] = array_of(report.files);
  json["notes"] = report.notes;
  return json;
}

}  // namespace isoextract::convert
