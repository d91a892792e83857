#include "convert/stage_report.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "convert/json_values.hpp"

namespace isoextract::convert {
namespace {

std::string value_text(const Value& value) {
  const Json json = value.json();
  if (json.is_number_float()) return fmt::format("{:.4g}", json.get<double>());
  return json.is_string() ? json.get<std::string>() : json.dump();
}

std::string figure_text(const Figure& figure) {
  std::string name(word_of(figure.key));
  std::ranges::replace(name, '_', ' ');
  if (figure.value.is_integer()) return fmt::format("{} {}", value_text(figure.value), name);
  const Figures* const parts = figure.value.parts();
  if (parts == nullptr) return fmt::format("{} {}", name, value_text(figure.value));
  std::vector<std::string> texts;
  for (const Figure& part : *parts) {
    texts.push_back(fmt::format("{} {}", value_text(part.value), word_of(part.key)));
  }
  return fmt::format("{} {}", name, fmt::join(texts, ", "));
}

}  // namespace

Value::Value(Figures parts) : kind_(Kind::parts), parts_(std::make_shared<const Figures>(std::move(parts))) {}

Value::Value(const field::Box& box) : Value(Figures{{Key::min, box.min}, {Key::max, box.max}}) {}

Value::Value(const field::IndexBox& box) {
  if (box.empty()) return;
  const auto corner = [](const auto& v) { return List{v.x, v.y, v.z}; };
  *this = Value(Figures{{Key::min, corner(box.min)}, {Key::max, corner(box.max)}});
}

Value::Value(const field::Affine& map) {
  const glm::dmat3& m = map.linear;
  kind_ = Kind::list;
  for (int row = 0; row < 3; ++row) list_.emplace_back(List{m[0][row], m[1][row], m[2][row], map.offset[row]});
}

Value::Value(const StageTime& time)
    : Value(Figures{{Key::wall_seconds, time.wall_seconds}, {Key::cpu_seconds, time.cpu_seconds}}) {}

Value::Value(const SurfaceId& id)
    : Value(id.is_label() ? Value(id.label())
            : id.is_iso() ? Value(id.iso())
                          : Value(id.text())) {}

Json Value::json() const {
  switch (kind_) {
    case Kind::none: break;
    case Kind::yes_or_no: return integer_ != 0;
    case Kind::integer: return integer_;
    case Kind::number: return number_;
    case Kind::text: return text_;
    case Kind::list: {
      Json list = Json::array();
      for (const Value& value : list_) list.push_back(value.json());
      return list;
    }
    case Kind::parts: return json_of(*parts_);
  }
  return nullptr;
}

Json json_of(const Figures& figures) {
  Json json = Json::object();
  for (const Figure& figure : figures) {
    if (figure.in_report) json[std::string(word_of(figure.key))] = figure.value.json();
  }
  return json;
}

const Value* find(const Figures& figures, std::initializer_list<Key> path) {
  const Figures* parts = &figures;
  const Value* found = nullptr;
  for (const Key key : path) {
    if (parts == nullptr) return nullptr;
    const auto figure = std::ranges::find(*parts, key, &Figure::key);
    if (figure == parts->end() || figure->value.is_none()) return nullptr;
    found = &figure->value;
    parts = found->parts();
  }
  return found;
}

SurfaceId surface_id_at(const Figures& figures) {
  const Value* const id = find(figures, {Key::iso});
  if (id->is_text()) return surface_id_of_mesh(id->as<std::string>());
  return id->is_integer() ? SurfaceId(Label{id->as<std::int64_t>()}) : SurfaceId(id->as<double>());
}

void set(Figures& figures, Key key, Value value) {
  const auto found = std::ranges::find(figures, key, &Figure::key);
  if (found != figures.end()) found->value = std::move(value);
}

std::string text_of(const Figures& figures) {
  std::vector<std::string> parts;
  for (const Figure& figure : figures) {
    if (figure.in_report && figure.key != Key::time) parts.push_back(figure_text(figure));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

void StageReport::add_timed(Figures figures, const StageTime& taken) {
  figures.emplace_back(Key::time, taken);
  entries.push_back(std::move(figures));
  time = taken;
}

StageReport report_on(StageName stage, const std::string& label) { return StageReport(stage, label, label); }

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
  if (report.id) json[std::string(word_of(Key::iso))] = json_of(*report.id);
  json.update(json_of(figures));
  if (report.stage == StageName::extract) {
    Json& work = json[std::string(word_of(Key::work))] = Json::array();
    for (const WorkFact& fact : report.work) work.push_back(json_of(fact));
  }
  if (!report.grid.empty()) json[std::string(word_of(Key::grid))] = report.grid;
  return json;
}

std::vector<StageReport::Part> times_of(const StageReport& report) {
  if (!report.parts.empty()) return report.parts;
  if (!report.time || !stage_info(report.stage).is_timed) return {};
  return {{report.stage, report.id, *report.time}};
}

}  // namespace isoextract::convert
