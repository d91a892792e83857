#include "convert/stage_report.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace isoextract::convert {
namespace {

std::string value_text(const Json& value) {
  if (value.is_number_float()) return fmt::format("{:.4g}", value.get<double>());
  return value.is_string() ? value.get<std::string>() : value.dump();
}

std::string figure_text(const Figure& figure) {
  std::string name(word_of(figure.key));
  std::ranges::replace(name, '_', ' ');
  if (figure.value.is_number_integer()) return fmt::format("{} {}", value_text(figure.value), name);
  if (!figure.value.is_object()) return fmt::format("{} {}", name, value_text(figure.value));
  std::vector<std::string> parts;
  for (const auto& [part, value] : figure.value.items()) parts.push_back(fmt::format("{} {}", value_text(value), part));
  return fmt::format("{} {}", name, fmt::join(parts, ", "));
}

}  // namespace

Json json_of(const Figures& figures) {
  Json json = Json::object();
  for (const Figure& figure : figures) {
    if (figure.is_told) json[std::string(word_of(figure.key))] = figure.value;
  }
  return json;
}

const Json* find(const Figures& figures, std::initializer_list<Key> path) {
  const auto first = std::ranges::find(figures, *path.begin(), &Figure::key);
  const Json* found = first != figures.end() ? &first->value : nullptr;
  for (const Key* key = path.begin() + 1; found != nullptr && key != path.end(); ++key) {
    const auto part = found->find(std::string(word_of(*key)));
    found = part != found->end() ? &*part : nullptr;
  }
  return found != nullptr && !found->is_null() ? found : nullptr;
}

void set(Figures& figures, Key key, Json value) {
  const auto found = std::ranges::find(figures, key, &Figure::key);
  if (found != figures.end()) found->value = std::move(value);
}

std::string text_of(const Figures& figures) {
  std::vector<std::string> parts;
  for (const Figure& figure : figures) {
    if (figure.is_told && figure.key != Key::time) parts.push_back(figure_text(figure));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

void StageReport::add_timed(Figures figures, const StageTime& taken) {
  figures.emplace_back(Key::time, json_of(taken));
  entries.push_back(std::move(figures));
  time = taken;
}

StageReport report_on(StageName stage, const std::string& label) {
  return {.stage = stage, .subject = label, .label = label};
}

StageReport report_on_field(StageName stage, const std::string& label, WorkFact fact, const StageTime& time) {
  StageReport report = report_on(stage, label);
  report.time = time;
  report.did = stage_info(stage).done;
  report.lines.push_back({fmt::format("{}: {}", word_of(fact.done), fact.text)});
  report.work.push_back(std::move(fact));
  return report;
}

Json entry_of(const StageReport& report, const Figures& figures) {
  Json json = Json::object();
  if (report.iso) json[std::string(word_of(Key::iso))] = *report.iso;
  json.update(json_of(figures));
  if (!report.grid.empty()) json[std::string(word_of(Key::grid))] = report.grid;
  return json;
}

std::vector<StageReport::Part> times_of(const StageReport& report) {
  if (!report.parts.empty()) return report.parts;
  if (!report.time || !stage_info(report.stage).is_timed) return {};
  return {{report.stage, report.iso, *report.time}};
}

}  // namespace isoextract::convert
