#include "convert/outcome.hpp"

#include <filesystem>
#include <numeric>

#include <fmt/format.h>

#include "base/version.hpp"

namespace isoextract::convert {
namespace {

using convert::json_of;

// The job, and what is made of it for readers of the document.
Json options_of(const ConversionJob& job, std::uint64_t memory_limit) {
  Json json = json_of(job);
  json["iso"] = Json::array();
  for (const IsoChoice& iso : job.isos()) json["iso"].push_back(json_of(iso));
  json["unit"] = job.source.placement.unit.empty() ? Json(nullptr) : Json(job.source.placement.unit);
  const std::string& to_unit = job.source.placement.to_unit;
  json["to_unit"] = to_unit.empty() ? Json(nullptr) : Json(to_unit);
  const SimplifyChoice simplify = job.simplify.value_or(SimplifyChoice());
  json["simplify"] = simplify.within ? Json(simplify_bound_text(*simplify.within)) : Json(nullptr);
  json["triangles"] = simplify.triangles ? Json(triangle_count_text(*simplify.triangles)) : Json(nullptr);
  if (job.field_file) json["format"] = "vdb";
  if (job.picture_file) json["format"] = "png";
  json["memory_limit"] = memory_limit;
  return json;
}

Json device_of(const Outcome& outcome) {
  if (outcome.backend.empty()) return nullptr;
  return {{"backend", outcome.backend},
          {"name", outcome.device.empty() ? Json(nullptr) : Json(outcome.device)},
          {"threads", outcome.threads}};
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
  json["inside"] = word_of(input.kind);
  json["value_scale"] = {{"slope", input.scale.slope}, {"intercept", input.scale.intercept}};
  json["index_to_world"] = json_of(input.index_to_world);
  json["world_space"] = input.world_space;
  json["length_unit"] = input.length_unit;
  json["creator"] = input.creator;
  return json;
}

Json json_of(const ParticleRecord& record) {
  const points::FieldFigures& figures = record.figures;
  return {{"format", record.format},
          {"length_unit", record.length_unit},
          {"method", word_of(record.method)},
          {"radius", figures.radius},
          {"radius_suggested", figures.radius_suggested},
          {"smoothing_length", optional_json(record.smoothing_length)},
          {"spacing", figures.spacing},
          {"support", figures.support},
          {"particles", figures.particles},
          {"not_finite", figures.particles_dropped},
          {"left_out_inside", figures.particles_left_out},
          {"too_small", figures.particles_too_small},
          {"radius_attribute", figures.radius_attribute.empty() ? Json(nullptr) : Json(figures.radius_attribute)},
          {"bricks_stored", figures.bricks_stored},
          {"bricks_inside", figures.bricks_inside},
          {"time", json_of(record.time)}};
}

Json json_of(const PlacedField& placed) {
  const Placement& placement = placed.placement.placement;
  return {{"unit", placement.unit.empty() ? Json(nullptr) : Json(placement.unit)},
          {"to_unit", placement.to_unit.empty() ? Json(nullptr) : Json(placement.to_unit)},
          {"scale", placement.scale},
          {"moved_by", json_of(placed.placement.moved_by)}};
}

Json json_of(const StageRecord& stage) {
  Json json{{"stage", word_of(stage.stage)}};
  if (stage.iso) json["iso"] = *stage.iso;
  json.update(json_of(stage.time));
  return json;
}

Json json_of(const WorkFact& fact) {
  Json json{{"what", word_of(fact.what)}, {"done", word_of(fact.done)}};
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
  json["component_table"] = json_of(mesh.component_table);
  if (mesh.error) json["error"] = json_of(*mesh.error);
  return json;
}

Json json_of(const AttributeRecord& record) {
  return {{"iso", record.iso},
          {"name", record.name},
          {"source", record.source},
          {"components", record.components},
          {"kind", word_of(record.kind)},
          {"changed", record.changed},
          {"vertices", record.vertices},
          {"outside", record.outside},
          {"not_finite", record.not_finite},
          {"out_of_reach", record.out_of_reach}};
}

Json json_of(const ColourRecord& record) {
  return {{"iso", record.iso},
          {"attribute", record.attribute},
          {"map", word_of(record.map)},
          {"range", {record.min, record.max}},
          {"own_range", record.own_range},
          {"not_numbers", record.not_numbers}};
}

Json json_of(const MeshSimplification& record) {
  const auto range = [](const DistanceRange& r) { return Json{{"lower", r.lower}, {"upper", r.upper}}; };
  Json asked = nullptr;
  if (const auto& within = record.asked.within) {
    asked = {{"distance", within->distance}, {"unit", within->in_world_units ? "world" : "voxel"}};
  }
  return {
      {"iso", record.iso},
      {"asked", asked},
      {"asked_triangles", record.asked.triangles ? Json(triangle_count_text(*record.asked.triangles)) : Json(nullptr)},
      {"measured", {{"voxels", range(record.voxels)}, {"world", range(record.world)}}},
      {"triangles_before", record.facts.triangles_before},
      {"triangles_after", record.facts.triangles_after},
      {"passes", record.facts.passes},
      {"components", record.components},
      {"turned_inside_out", record.turned},
      {"left_bodies", record.left_bodies},
      {"time", json_of(record.facts.time)}};
}

Json json_of(const MeshPackingRecord& record) {
  Json json{{"iso", record.iso},
            {"file", record.file},
            {"compression", word_of(record.asked.compression)},
            {"bytes_before", record.facts.bytes_before},
            {"bytes_after", record.facts.bytes_after},
            {"positions", nullptr},
            {"normal_degrees", optional_json(record.facts.largest_normal_turn)},
            {"flattened_triangles", record.facts.flattened_triangles},
            {"one_by_one", record.facts.one_by_one},
            {"time", json_of(record.facts.time)}};
  if (const auto& positions = record.facts.positions) {
    const auto length = [&](double world) { return Json{{"voxels", world / record.voxel}, {"world", world}}; };
    json["positions"] = {
        {"bits", positions->bits},
        {"step", length(positions->step)},
        {"measured", {{"axis", length(positions->largest_axis)}, {"distance", length(positions->largest)}}}};
  }
  return json;
}

Json json_of(const meshes::WrittenFile& file) { return {{"path", file.path}, {"bytes", file.bytes}}; }

Json json_of(const ExtractionRecord& extraction);

template <class T>
Json array_of(const std::vector<T>& records) {
  Json array = Json::array();
  for (const T& record : records) {
    array.push_back(json_of(record));
    if constexpr (requires { record.grid; }) {
      if (!record.grid.empty()) array.back()["grid"] = record.grid;
    }
  }
  return array;
}

Json json_of(const ExtractionRecord& extraction) {
  Json json{{"iso", extraction.iso}};
  if (!extraction.asked.is_number()) json["asked"] = json_of(extraction.asked);
  json["triangles"] = extraction.triangles;
  json["work"] = array_of(extraction.work);
  return json;
}

}  // namespace

InputFacts input_facts(const std::string& path, const field::ScalarField& field) {
  InputFacts facts;
  facts.path = path;
  facts.format = field.format;
  facts.name = field.name;
  facts.world_space = field.world_space;
  facts.length_unit = field.length_unit;
  facts.creator = field.creator;
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

Result<MeshRecord> mesh_record(double iso, const std::string& file, const mesh::Mesh& mesh, const Context& context) {
  context.progress().begin("measuring", 0);
  auto topology = TRY(mesh::measure_topology(mesh, context));
  auto components = TRY(component_table(mesh, context));
  return MeshRecord{iso,
                    file,
                    mesh.name,
                    mesh.positions.size(),
                    mesh.triangles.size(),
                    mesh.origin,
                    mesh::measure_bounds(mesh),
                    mesh::measure_size(mesh),
                    topology,
                    std::move(components),
                    std::nullopt};
}

MeshRecord record_as_written(MeshRecord record, const std::string& file, const mesh::Mesh& mesh,
                             std::optional<MeshError> error) {
  record.file = file;
  record.name = mesh.name;
  record.vertices = mesh.positions.size();
  record.error = error;
  return record;
}

Json report_of(const ConversionJob* job, const Outcome& report, const std::vector<std::string>& arguments,
               std::uint64_t memory_limit, const std::string& hint) {
  Json json{{"schema_version", kReportSchemaVersion},
            {"program", {{"name", "isoextract"}, {"version", version()}}},
            {"status", report.error ? "failed" : "done"}};
  if (report.error) {
    json["error"] = json_of(*report.error);
    json["error"]["hint"] = hint;
  }
  json["arguments"] = arguments;
  json["options"] = job != nullptr ? options_of(*job, memory_limit) : Json(nullptr);
  json["device"] = device_of(report);
  json["input"] = report.input ? json_of(*report.input) : Json(nullptr);
  if (!report.more_grids.empty()) json["more_grids"] = array_of(report.more_grids);
  if (report.particles) json["particles"] = json_of(*report.particles);
  json["output_from_index"] = report.placed ? json_of(report.placed->output_from_index) : Json(nullptr);
  json["region"] = report.placed && report.placed->region ? json_of(*report.placed->region) : Json(nullptr);
  if (report.placed) json["placement"] = json_of(*report.placed);
  if (!report.isos.empty()) json["iso_values"] = array_of(report.isos);
  json["stages"] = array_of(report.stages);
  json["total"] = json_of(report.total);
  const std::uint64_t written =
      std::accumulate(report.files.begin(), report.files.end(), std::uint64_t{0},
                      [](std::uint64_t sum, const meshes::WrittenFile& f) { return sum + f.bytes; });
  json["bytes"] = {{"read", report.bytes_read}, {"written", written}, {"uploaded", report.bytes_uploaded}};
  json["peak_memory_bytes"] = report.peak_memory;
  json["reserved_memory_bytes"] = report.reserved_memory;
  json["work"] = array_of(report.work);
  json["extractions"] = array_of(report.extractions);
  if (job != nullptr && job->verify) json["verification"] = array_of(report.verifications);
  if (job != nullptr && !job->source.attributes.empty()) json["attributes"] = array_of(report.attributes);
  if (job != nullptr && job->pieces.drops()) json["pieces"] = array_of(report.pieces);
  if (job != nullptr && job->surface.relaxes()) json["relaxations"] = array_of(report.relaxations);
  if (job != nullptr && job->smooth) json["smoothings"] = array_of(report.smoothings);
  json["simplifications"] = array_of(report.simplifications);
  if (job != nullptr && job->colour && job->colour->attribute) json["colours"] = array_of(report.colours);
  if (job != nullptr && job->packing.packs()) {
    json["packings"] = array_of(report.packings);
  }
  json["meshes"] = array_of(report.meshes);
  json["files"] = array_of(report.files);
  json["notes"] = report.notes;
  return json;
}

}  // namespace isoextract::convert
