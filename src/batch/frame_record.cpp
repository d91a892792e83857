#include "batch/frame_record.hpp"

#include <algorithm>
#include <map>
#include <string_view>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include "convert/json_values.hpp"
#include "convert/particle_source.hpp"
#include "field/demo_field.hpp"
#include "files/file_version.hpp"
#include "files/output_file.hpp"

namespace isoextract::batch {
namespace {

using convert::Figures;
using convert::Key;
using convert::StageName;
using convert::StageReport;

using convert::Json;

Result<FileRecord> file_record_of(const mesh_io::WrittenFile& file, const Context& context) {
  const auto version = files::version_of(std::filesystem::path(file.path));
  if (file.hash && version && version->bytes == file.bytes) {
    return FileRecord{file.path, {file.bytes, version->modified, *file.hash}, {}};
  }
  const files::ContentState state = TRY(files::hash_file(file.path, context));
  return FileRecord{file.path, state, {}};
}

// Returns a message about the first file whose bytes, or `with_times` also whose modification time, changed; empty if
// no file changed.
std::string first_changed_file(const std::vector<FileRecord>& before, bool with_times) {
  for (const FileRecord& file : before) {
    const auto now = files::hash_part({file.path, file.ranges}, Context());
    if (!now && !file.ranges.empty() && files::is_there(file.path)) return fmt::format("{} has changed", file.path);
    if (!now) return fmt::format("the run cannot read {}", file.path);
    if (!file.ranges.empty()) {  // other frames of the file may have changed
      if (now->hash != file.state.hash) return fmt::format("{} has changed", file.path);
      continue;
    }
    const bool same = now->bytes == file.state.bytes && now->hash == file.state.hash;
    if (!same || (with_times && now->modified != file.state.modified)) return fmt::format("{} has changed", file.path);
  }
  return {};
}

bool is_demo(const FrameJob& frame) { return frame.job.source.input.starts_with(field::kDemoPrefix); }

// Returns the parts of all input files, sorted by path, without duplicates; none for a demo field.
Result<std::vector<files::FilePart>> input_parts(const FrameJob& frame, const Context& context) {
  if (is_demo(frame)) return std::vector<files::FilePart>();
  auto parts = TRY(convert::list_source_parts(frame.job.source, context.beside()));
  std::ranges::sort(parts, {}, &files::FilePart::path);
  // A path may be listed twice, with different ranges: the whole file contains both.
  const auto same_path = [](const files::FilePart& a, const files::FilePart& b) { return a.path == b.path; };
  for (auto at = std::ranges::adjacent_find(parts, same_path); at != parts.end();
       at = std::ranges::adjacent_find(parts, same_path)) {
    if (at->ranges != (at + 1)->ranges) at->ranges.clear();
    parts.erase(at + 1);
  }
  return parts;
}

template <class T>
std::optional<T> optional_of(const Json& json, const char* key) {
  return json.at(key).is_null() ? std::nullopt : std::optional(json.at(key).get<T>());
}

// Paths may hold bytes that are not UTF-8, which JSON text cannot: these become lists of byte values.
Json bytes_json(const std::string& text) {
  Json codes = Json::array();
  const bool plain = std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
  if (plain) return text;
  for (const char c : text) codes.push_back(static_cast<unsigned char>(c));
  return codes;
}

std::string bytes_of(const Json& json) {
  if (json.is_string()) return json.get<std::string>();
  std::string text;
  for (const Json& code : json) text += static_cast<char>(code.get<std::uint8_t>());
  return text;
}

Json json_of(const std::vector<FileRecord>& files) {
  Json list = Json::array();
  for (const FileRecord& file : files) {
    list.push_back({{"path", bytes_json(file.path)},
                    {"bytes", file.state.bytes},
                    {"modified", file.state.modified},
                    {"hash", file.state.hash}});
    if (file.ranges.empty()) continue;
    Json& ranges = list.back()["ranges"] = Json::array();
    for (const files::ByteRange& range : file.ranges) ranges.push_back({range.offset, range.bytes});
  }
  return list;
}

std::vector<FileRecord> files_of(const Json& json) {
  std::vector<FileRecord> files;
  for (const Json& file : json) {
    files.push_back({bytes_of(file.at("path")),
                     {file.at("bytes").get<std::uint64_t>(), file.at("modified").get<std::int64_t>(),
                      file.at("hash").get<std::string>()},
                     {}});
    if (!file.contains("ranges")) continue;
    for (const Json& range : file.at("ranges"))
      files.back().ranges.push_back({range.at(0).get<std::uint64_t>(), range.at(1).get<std::uint64_t>()});
  }
  return files;
}

Json json_of(const std::vector<SurfaceFigures>& list) {
  Json surfaces = Json::array();
  for (const SurfaceFigures& surface : list) {
    surfaces.push_back({{"iso", json_of(surface.id)},
                        {"asked", surface.asked},
                        {"triangles", surface.triangles},
                        {"vertices", convert::optional_json(surface.vertices)},
                        {"components", convert::optional_json(surface.components)},
                        {"closed", convert::optional_json(surface.closed)},
                        {"area", convert::optional_json(surface.area)},
                        {"volume", convert::optional_json(surface.volume)},
                        {"output", bytes_json(surface.output)},
                        {"bytes", convert::optional_json(surface.bytes)},
                        {"error_rms", convert::optional_json(surface.error_rms)},
                        {"error_max", convert::optional_json(surface.error_max)},
                        {"coverage_rms", convert::optional_json(surface.coverage_rms)},
                        {"coverage_max", convert::optional_json(surface.coverage_max)}});
    if (!surface.grid.empty()) surfaces.back()["grid"] = bytes_json(surface.grid);
    if (!surface.files.empty()) surfaces.back()["files"] = json_of(surface.files);
  }
  return surfaces;
}

Json json_of(const FrameFigures& figures) {
  return {{"surfaces", json_of(figures.surfaces)},
          {"step", convert::optional_json(figures.time.step)},
          {"time", convert::optional_json(figures.time.time)},
          {"lacked_attributes", figures.lacked_attributes},
          {"bytes", figures.bytes},
          {"wall_seconds", figures.wall_seconds},
          {"memory", figures.memory},
          {"unit", figures.unit},
          {"front", figures.front}};
}

std::vector<SurfaceFigures> surfaces_of(const Json& json) {
  std::vector<SurfaceFigures> surfaces;
  for (const Json& surface : json) {
    surfaces.push_back({convert::surface_id_of(surface.at("iso")), surface.value("asked", std::string()),
                        surface.at("triangles").get<std::uint64_t>(), optional_of<std::uint64_t>(surface, "vertices"),
                        optional_of<std::uint64_t>(surface, "components"), optional_of<bool>(surface, "closed"),
                        optional_of<double>(surface, "area"), optional_of<double>(surface, "volume"),
                        bytes_of(surface.at("output")), optional_of<std::uint64_t>(surface, "bytes"),
                        optional_of<double>(surface, "error_rms"), optional_of<double>(surface, "error_max"),
                        optional_of<double>(surface, "coverage_rms"), optional_of<double>(surface, "coverage_max"),
                        surface.contains("grid") ? bytes_of(surface.at("grid")) : std::string(),
                        surface.contains("files") ? surfaces_of(surface.at("files")) : std::vector<SurfaceFigures>()});
  }
  return surfaces;
}

FrameFigures figures_of(const Json& json) {
  FrameFigures figures;
  figures.surfaces = surfaces_of(json.at("surfaces"));
  figures.time = {optional_of<std::int64_t>(json, "step"), optional_of<double>(json, "time")};
  figures.lacked_attributes = json.value("lacked_attributes", std::vector<std::string>());
  figures.unit = json.value("unit", std::string());
  figures.front = json.value("front", 0.0);
  figures.bytes = json.at("bytes").get<std::uint64_t>();
  figures.wall_seconds = json.at("wall_seconds").get<double>();
  figures.memory = json.at("memory").get<std::uint64_t>();
  return figures;
}

// The parts of an outcome that belong to one surface, in the outcome's order.
struct SurfaceParts {
  std::vector<const convert::WrittenSurface*> written;
  std::vector<const Figures*> meshes;
  const Figures* error = nullptr;  // of its first measurement
};

// Sorts the parts of an outcome by their surface in one pass, because a label map may have 100,000 surfaces.
class PartsBySurface {
 public:
  explicit PartsBySurface(const convert::Outcome& outcome) {
    for (const convert::WrittenSurface& written : outcome.written) {
      parts_[{written.id, written.grid}].written.push_back(&written);
    }
    for (const StageReport& report : outcome.reports) {
      if (report.stage == StageName::error) {
        SurfaceParts& parts = parts_[{*report.id, report.grid}];
        if (parts.error == nullptr) parts.error = &report.entries.front();
      }
      if (report.stage != StageName::mesh_facts) continue;
      for (const Figures& mesh : report.entries) {
        parts_[{surface_id_at(mesh), value_at<std::string>(mesh, {Key::grid}).value_or("")}].meshes.push_back(&mesh);
        mesh_of_file_.emplace(*value_at<std::string>(mesh, {Key::file}), &mesh);
      }
    }
  }

  [[nodiscard]] const SurfaceParts& of(const SurfaceFigures& surface) { return parts_[{surface.id, surface.grid}]; }

  // Returns the first mesh in a file, or null.
  [[nodiscard]] const Figures* mesh_of_file(const std::string& file) const {
    const auto found = mesh_of_file_.find(file);
    return found != mesh_of_file_.end() ? found->second : nullptr;
  }

 private:
  std::map<std::pair<convert::SurfaceId, std::string>, SurfaceParts> parts_;  // by surface and grid
  std::unordered_map<std::string, const Figures*> mesh_of_file_;
};

// Adds the figures of the files of a surface. Counts only the first output: another output may repeat the surface.
void add_written(const convert::Outcome& outcome, const SurfaceParts& parts, SurfaceFigures& figures) {
  std::size_t counted = 0;  // files before this index are in the sum
  for (const convert::WrittenSurface* surface : parts.written) {
    if (surface->output != parts.written.front()->output) continue;
    figures.triangles += surface->triangles;
    const std::size_t end = std::min(surface->first_file + surface->files, outcome.files.size());
    for (std::size_t file = std::max(counted, surface->first_file); file < end; ++file) {
      if (!figures.bytes) figures.output = outcome.files[file].path;
      figures.bytes = figures.bytes.value_or(0) + outcome.files[file].bytes;
    }
    counted = std::max(counted, end);
  }
}

void add_error(const SurfaceParts& parts, SurfaceFigures& figures) {
  if (parts.error == nullptr) return;
  const Figures& found = *parts.error;
  figures.error_rms = value_at<double>(found, {Key::interior, Key::rms, Key::voxels});
  figures.error_max = value_at<double>(found, {Key::interior, Key::max, Key::voxels});
  figures.coverage_rms = value_at<double>(found, {Key::coverage, Key::distances, Key::rms, Key::voxels});
  figures.coverage_max = value_at<double>(found, {Key::coverage, Key::distances, Key::max, Key::voxels});
}

void add_mesh(const Figures& mesh, SurfaceFigures& surface) {
  const auto count = [&](Key key) { return value_at<std::uint64_t>(mesh, {key}).value_or(0); };
  surface.vertices = surface.vertices.value_or(0) + count(Key::vertices);
  surface.components = surface.components.value_or(0) + count(Key::components);
  surface.closed = surface.closed.value_or(true) && value_at<bool>(mesh, {Key::closed}).value_or(false);
  surface.area = surface.area.value_or(0) + value_at<double>(mesh, {Key::area}).value_or(0);
  surface.volume = surface.volume.value_or(0) + value_at<double>(mesh, {Key::volume}).value_or(0);
}

// Adds the figures of the meshes of a surface: several if its bodies are separate meshes.
void add_meshes(const SurfaceParts& parts, SurfaceFigures& surface) {
  // A second output may repeat the surface: count each mesh name from one file only. Bodies have names of their own.
  std::unordered_map<std::string, std::string> file_of_name;
  for (const Figures* mesh : parts.meshes) {
    const std::string file = *value_at<std::string>(*mesh, {Key::file});
    if (file_of_name.try_emplace(*value_at<std::string>(*mesh, {Key::name}), file).first->second != file) continue;
    add_mesh(*mesh, surface);
  }
  if (!surface.closed.value_or(false)) surface.volume.reset();
}

// Adds the figures of each file of a surface whose bodies have files of their own.
void add_files(const convert::Outcome& outcome, const SurfaceParts& parts, const PartsBySurface& all,
               SurfaceFigures& surface) {
  std::vector<SurfaceFigures> files;
  std::size_t end = 0;  // end of the files counted so far
  for (const convert::WrittenSurface* piece : parts.written) {
    if (piece->output != parts.written.front()->output) continue;
    if (piece->files == 0 || piece->first_file + piece->files > outcome.files.size()) continue;
    if (!files.empty() && piece->first_file < end) return;  // the bodies share a file
    end = piece->first_file + piece->files;
    SurfaceFigures& file = files.emplace_back(surface);
    file.triangles = piece->triangles;
    file.output = outcome.files[piece->first_file].path;
    file.bytes = 0;
    for (std::size_t i = piece->first_file; i < end; ++i) *file.bytes += outcome.files[i].bytes;
    file.vertices.reset();
    file.components.reset();
    file.closed.reset();
    file.area.reset();
    file.volume.reset();
    if (const Figures* mesh = all.mesh_of_file(file.output); mesh != nullptr) add_mesh(*mesh, file);
    if (!file.closed.value_or(false)) file.volume.reset();
  }
  if (files.size() > 1) surface.files = std::move(files);
}

// Adds the optional attributes that the input lacks. An attribute may be requested twice: for the file and for colors.
void add_missing_attributes(const StageReport& report, std::vector<std::string>& lacked) {
  for (const Figures& attribute : report.entries) {
    const auto name = value_at<std::string>(attribute, {Key::attribute}).value_or("");
    if (std::ranges::find(lacked, name) == lacked.end()) lacked.push_back(name);
  }
}

// Returns the extracted surfaces, or the meshes of a mesh file, without their figures.
std::vector<SurfaceFigures> surfaces_of(const convert::Outcome& outcome) {
  std::vector<SurfaceFigures> surfaces;
  const auto add = [&](const convert::SurfaceId& id) -> SurfaceFigures& {
    SurfaceFigures& surface = surfaces.emplace_back();
    surface.id = id;
    return surface;
  };
  for (const StageReport& report : outcome.reports) {
    if (report.stage != StageName::extract) continue;
    SurfaceFigures& surface = add(*report.id);
    surface.grid = report.grid;
    surface.asked = value_at<std::string>(report.entries.front(), {Key::asked}).value_or("");
  }
  const StageReport* const read = outcome.first(StageName::read_mesh);
  if (read == nullptr || !outcome.done()) return surfaces;
  // Meshes that were skipped as empty are not among the written ones, but they have rows.
  const bool are_apart = std::ranges::any_of(
      outcome.written, [](const convert::WrittenSurface& mesh) { return !mesh.id.is_only_surface(); });
  if (!are_apart) add(convert::kWholeFile);
  const auto parts = value_at<std::uint64_t>(read->entries.front(), {Key::parts}).value_or(0);
  for (std::uint64_t i = 1; are_apart && i <= parts; ++i) add(convert::FileMesh{i});
  return surfaces;
}

std::string text_at(const convert::Outcome& outcome, StageName stage, Key key) {
  const StageReport* const report = outcome.first(stage);
  return report != nullptr ? value_at<std::string>(report->entries.front(), {key}).value_or("") : "";
}

}  // namespace

FrameFigures figures_of(const convert::Outcome& outcome) {
  FrameFigures figures;
  PartsBySurface all(outcome);
  for (const StageReport& report : outcome.reports) {
    if (report.stage == StageName::read_attributes) add_missing_attributes(report, figures.lacked_attributes);
  }
  figures.surfaces = surfaces_of(outcome);
  for (SurfaceFigures& surface : figures.surfaces) {
    const SurfaceParts& parts = all.of(surface);
    add_written(outcome, parts, surface);
    add_meshes(parts, surface);
    add_error(parts, surface);
    add_files(outcome, parts, all, surface);
  }
  if (const StageReport* const particles = outcome.first(StageName::particles_to_field)) {
    const Figures& made = particles->entries.front();
    figures.time = {value_at<std::int64_t>(made, {Key::frame, Key::step}),
                    value_at<double>(made, {Key::frame, Key::time})};
  }
  figures.unit = text_at(outcome, StageName::place, Key::unit_of_lengths);
  figures.front = outcome.front;
  for (const mesh_io::WrittenFile& file : outcome.files) figures.bytes += file.bytes;
  figures.wall_seconds = outcome.total.wall_seconds;
  figures.memory = outcome.reserved_memory;
  return figures;
}

std::vector<const SurfaceFigures*> rows_of(const FrameFigures& figures) {
  std::vector<const SurfaceFigures*> rows;
  for (const SurfaceFigures& surface : figures.surfaces) {
    if (surface.files.empty()) rows.push_back(&surface);
    for (const SurfaceFigures& file : surface.files) rows.push_back(&file);
  }
  return rows;
}

Result<std::vector<FileRecord>> input_states(const FrameJob& frame, const Context& context) {
  std::vector<FileRecord> records;
  auto parts = TRY(input_parts(frame, context));
  for (files::FilePart& part : parts) {
    auto state = TRY(files::hash_part(part, context));
    records.push_back({part.path.string(), std::move(state), std::move(part.ranges)});
  }
  return records;
}

Result<FrameRecord> record_of(const FrameJob& frame, std::vector<FileRecord> inputs, const convert::Outcome& outcome,
                              const Context& context) {
  std::vector<FileRecord> outputs;
  for (const mesh_io::WrittenFile& file : outcome.files) {
    auto record = TRY(file_record_of(file, context));
    outputs.push_back(std::move(record));
  }
  return FrameRecord{frame.number, convert::hash_of(frame.job), std::move(inputs), std::move(outputs),
                     figures_of(outcome)};
}

bool knows_inputs(const FrameRecord& record, const FrameJob& frame) { return !record.inputs.empty() || is_demo(frame); }

std::string changed_file_message(const FrameRecord& record) {
  std::string changed = first_changed_file(record.inputs, true);
  return changed.empty() ? first_changed_file(record.outputs, false) : changed;
}

std::string added_input_message(const FrameRecord& record, const FrameJob& frame) {
  const auto parts = input_parts(frame, Context());
  if (!parts) return "the run cannot list its inputs";
  for (const files::FilePart& part : *parts) {
    const auto known = std::ranges::find(record.inputs, part.path.string(), &FileRecord::path);
    if (known == record.inputs.end()) return fmt::format("{} is new", part.path.string());
    if (known->ranges != part.ranges) return fmt::format("{} has changed", part.path.string());
  }
  return {};
}

std::string reason_to_reconvert(const FrameRecord& record, const FrameJob& frame) {
  if (record.job != convert::hash_of(frame.job)) return "its options have changed";
  if (!knows_inputs(record, frame)) return "its record lists no inputs";
  std::string changed = changed_file_message(record);
  return changed.empty() ? added_input_message(record, frame) : changed;
}

convert::Json json_of(const FrameRecord& record) {
  return {{"frame", record.frame},
          {"job", record.job},
          {"inputs", json_of(record.inputs)},
          {"outputs", json_of(record.outputs)},
          {"figures", json_of(record.figures)}};
}

std::optional<FrameRecord> record_of(const convert::Json& json) {
  try {
    return FrameRecord{json.at("frame").get<std::int64_t>(), json.at("job").get<std::string>(),
                       files_of(json.at("inputs")), files_of(json.at("outputs")), figures_of(json.at("figures"))};
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

}  // namespace isoextract::batch
