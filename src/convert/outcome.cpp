#include "convert/outcome.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "base/version.hpp"
#include "convert/json_values.hpp"
#include "convert/stages/mesh_simplify.hpp"

namespace isoextract::convert {
namespace {

using convert::json_of;

// Returns the job as JSON, with its iso values and units in the form that readers of the report use.
Json options_of(const ConversionJob& job, std::uint64_t memory_limit) {
  Json json = json_of(job);
  json["iso"] = Json::array();
  for (const IsoChoice& iso : job.isos()) json["iso"].push_back(json_of(iso));
  json["unit"] = job.source.placement.unit.empty() ? Json(nullptr) : Json(job.source.placement.unit);
  const std::string& to_unit = job.source.placement.to_unit;
  json["to_unit"] = to_unit.empty() ? Json(nullptr) : Json(to_unit);
  const SimplifyChoice simplify = job.edits.simplify.value_or(SimplifyChoice());
  json["simplify"] = simplify.within ? Json(simplify_bound_text(*simplify.within)) : Json(nullptr);
  json["triangles"] = simplify.triangles ? Json(triangle_count_text(*simplify.triangles)) : Json(nullptr);
  if (const auto* file = job.writes<FieldFileOptions>()) json["format"] = word_of(file->format);
  if (job.writes<PictureFileOptions>() != nullptr) json["format"] = "png";
  if (const auto* file = job.writes<ParticleFileOptions>()) json["format"] = word_of(file->format);
  json["memory_limit"] = memory_limit;
  return json;
}

Json device_of(const Outcome& outcome) {
  if (outcome.backend.empty()) return nullptr;
  return {{"backend", outcome.backend},
          {"name", outcome.device.empty() ? Json(nullptr) : Json(outcome.device)},
          {"threads", outcome.threads}};
}

Json json_of(const StageReport::Part& part) {
  Json json{{"stage", word_of(part.stage)}};
  if (part.id) json["iso"] = json_of(*part.id);
  json.update(json_of(part.time));
  return json;
}

Json json_of(const mesh_io::WrittenFile& file) { return {{"path", file.path}, {"bytes", file.bytes}}; }

template <class T>
Json array_of(const std::vector<T>& records) {
  Json array = Json::array();
  for (const T& record : records) array.push_back(json_of(record));
  return array;
}

Json entries_of(const Outcome& outcome, StageName stage) {
  Json array = Json::array();
  for (const StageReport& report : outcome.reports) {
    if (report.stage != stage) continue;
    for (const Figures& figures : report.entries) array.push_back(entry_of(report, figures));
  }
  return array;
}

// Returns the work on the input. The work of an extraction is in its own entry.
Json work_of(const Outcome& outcome) {
  Json array = Json::array();
  for (const StageReport& report : outcome.reports) {
    if (report.stage == StageName::extract) continue;
    for (const WorkFact& fact : report.work) array.push_back(json_of(fact));
  }
  return array;
}

// Adds the input, its particles, its placement and the iso values.
void add_input(const Outcome& outcome, Json& json) {
  Json inputs = entries_of(outcome, StageName::read);
  json["input"] = inputs.empty() ? Json(nullptr) : inputs.front();
  if (inputs.size() > 1) {
    inputs.erase(0);
    json["more_grids"] = std::move(inputs);
  }
  const Json particles = entries_of(outcome, StageName::particles_to_field);
  if (!particles.empty()) json["particles"] = particles.front();
  const StageReport* const place = outcome.first(StageName::place);
  for (const Key key : {Key::output_from_index, Key::region}) {
    const Value* const found = place != nullptr ? find(place->entries.front(), {key}) : nullptr;
    json[std::string(word_of(key))] = found != nullptr ? found->json() : Json(nullptr);
  }
  if (place != nullptr) json["placement"] = find(place->entries.front(), {Key::placement})->json();
  Json isos = entries_of(outcome, StageName::statistics);
  if (!isos.empty()) json["iso_values"] = std::move(isos);
}

}  // namespace

const StageReport* Outcome::first(StageName stage) const {
  const auto found = std::ranges::find_if(
      reports, [&](const StageReport& report) { return report.stage == stage && !report.entries.empty(); });
  return found != reports.end() ? &*found : nullptr;
}

std::vector<StageReport::Part> Outcome::times() const {
  std::vector<StageReport::Part> all;
  for (const StageReport& report : reports) {
    const std::vector<StageReport::Part> times = times_of(report);
    all.insert(all.end(), times.begin(), times.end());
  }
  return all;
}

Json report_of(const ConversionJob* job, const Outcome& report, const std::vector<std::string>& arguments,
               std::uint64_t memory_limit, const std::string& hint) {
  Json json{{"schema_version", kReportSchemaVersion},
            {"program", {{"name", "isoextract"}, {"version", version()}}},
            {"status", report.error ? "failed" : "done"}};
  if (report.error) json["error"] = json_of(*report.error, hint);
  json["arguments"] = arguments;
  json["options"] = job != nullptr ? options_of(*job, memory_limit) : Json(nullptr);
  json["device"] = device_of(report);
  add_input(report, json);
  json["stages"] = array_of(report.times());
  json["total"] = json_of(report.total);
  const std::uint64_t written =
      std::accumulate(report.files.begin(), report.files.end(), std::uint64_t{0},
                      [](std::uint64_t sum, const mesh_io::WrittenFile& f) { return sum + f.bytes; });
  json["bytes"] = {{"read", report.bytes_read}, {"written", written}, {"uploaded", report.bytes_uploaded}};
  json["peak_memory_bytes"] = report.peak_memory;
  json["reserved_memory_bytes"] = report.reserved_memory;
  json["work"] = work_of(report);
  for (const StageInfo& stage : kStages) {
    const bool is_asked = stage.asked == nullptr || (job != nullptr && stage.asked(*job));
    if (!stage.section.empty() && (is_asked || stage.is_listed)) {
      json[std::string(stage.section)] = entries_of(report, stage.name);
    }
  }
  json["files"] = array_of(report.files);
  json["notes"] = json_of_notes(report.notes);
  return json;
}

}  // namespace isoextract::convert
