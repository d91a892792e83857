#include "cli/particle_report.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/number_text.hpp"
#include "base/printable.hpp"
#include "base/stopwatch.hpp"
#include "cli/remedies.hpp"
#include "convert/json_values.hpp"
#include "convert/particle_choice.hpp"
#include "convert/particle_field.hpp"
#include "convert/particle_source.hpp"
#include "convert/placement.hpp"
#include "convert/simulation_box.hpp"
#include "points/sphere_set.hpp"

namespace isoextract::cli {
namespace {

using particle_io::FrameTime;

constexpr std::size_t kShownName = 80;  // bytes

// Returns the least and the greatest step or time of the frames; nothing if no frame states one.
template <class T>
std::optional<std::pair<T, T>> range_of(const std::vector<FrameTime>& frames, std::optional<T> FrameTime::*member) {
  std::optional<std::pair<T, T>> range;
  for (const FrameTime& frame : frames) {
    if (!(frame.*member)) continue;
    const T value = *(frame.*member);
    if (!range) range = {value, value};
    range = {std::min(range->first, value), std::max(range->second, value)};
  }
  return range;
}

template <class T>
convert::Json range_json(const std::optional<std::pair<T, T>>& range) {
  return range ? convert::Json{range->first, range->second} : convert::Json(nullptr);
}

std::vector<AttributeRange> ranges_of(const std::vector<particle_io::ParticleQuantity>& quantities,
                                      const points::ParticleSet& particles) {
  std::vector<AttributeRange> ranges;
  for (const particle_io::ParticleQuantity& quantity : quantities) {
    AttributeRange& range = ranges.emplace_back();
    range.quantity = quantity;
    const auto found = std::ranges::find(particles.attributes, quantity.name, &points::ParticleAttribute::name);
    if (found == particles.attributes.end()) continue;
    range.read = true;
    for (const float value : found->values) {
      if (!std::isfinite(value)) {
        ++range.not_finite;
        continue;
      }
      range.min = std::min<double>(range.min.value_or(value), value);
      range.max = std::max<double>(range.max.value_or(value), value);
    }
  }
  return ranges;
}

std::vector<WordCounts> words_of_particles(const points::ParticleSet& particles) {
  std::vector<WordCounts> all;
  for (const points::ParticleWords& words : particles.words) {
    WordCounts& found = all.emplace_back();
    found.name = words.name;
    for (const std::string& word : words.words) found.counts.emplace_back(word, 0);
    for (const std::uint32_t index : words.indices) ++found.counts[index].second;
    std::erase_if(found.counts, [](const auto& count) { return count.second == 0; });
    found.words = found.counts.size();
    std::ranges::stable_sort(found.counts, std::ranges::greater(), [](const auto& count) { return count.second; });
    found.counts.resize(std::min(found.counts.size(), kShownWords));
  }
  return all;
}

// Returns "O 2000, H 1000".
std::string words_text(const WordCounts& words) {
  if (words.words == 0) return "words, too many to list";
  std::string text;
  for (const auto& [word, count] : words.counts) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", word.empty() ? "''" : printable(word, kShownName), count);
  }
  if (words.words > words.counts.size()) text += fmt::format(", and {} more", words.words - words.counts.size());
  return text;
}

std::string range_text(const AttributeRange& range) {
  if (!range.read) return "no numbers";
  std::string text =
      range.min ? fmt::format("{} .. {}", number_text(*range.min), number_text(*range.max)) : std::string("no values");
  if (range.not_finite > 0) text += fmt::format(", {} not finite as 32-bit floats", range.not_finite);
  return text;
}

void add_attributes(NamedLines& lines, const std::vector<AttributeRange>& ranges,
                    const std::vector<WordCounts>& words) {
  lines.add("attributes", fmt::format("{}", ranges.size()));
  std::size_t width = 4;
  for (const AttributeRange& range : ranges) {
    width = std::max(width, printable(range.quantity.name, kShownName).size());
  }
  for (const AttributeRange& range : ranges) {
    const particle_io::ParticleQuantity& quantity = range.quantity;
    const auto counts = std::ranges::find(words, quantity.name, &WordCounts::name);
    lines.plain(fmt::format(
        "    {:<{}}  {:<10}  {}{}", printable(quantity.name, kShownName), width,
        quantity.components == 1 ? quantity.type : fmt::format("{} x {}", quantity.type, quantity.components),
        counts != words.end() ? words_text(*counts) : range_text(range),
        quantity.unit.empty() ? "" : fmt::format(" ({})", printable(quantity.unit, kShownName))));
  }
}

void add_field(NamedLines& lines, const ParticleReport& report) {
  const points::MethodInfo& method = points::method_info(report.method);
  if (report.no_field) {
    const std::string hint = hint_text(report.no_field->hint);
    lines.add("field", fmt::format("none: {}{}", report.no_field->message, hint.empty() ? "" : "; " + hint));
    return;
  }
  if (!report.figures || report.figures->particles == 0) return;
  lines.add("field", fmt::format("{}: samples {:.6g} apart, in {} (8x8x8)", method.title, report.figures->spacing,
                                 counted(report.figures->bricks_stored, "brick")));
  lines.add(
      "time",
      fmt::format("{:.2f} s to read, {:.2f} s to make the field in this run; the extraction takes additional time",
                  report.read_seconds, report.field_seconds));
}

Result<points::ParticleField> measured_field(points::ParticleSet& particles, const convert::SourceOptions& source,
                                             Notes& notes, const Context& context) {
  const convert::SphereSpacing chosen = TRY(convert::choose_sphere_spacing(particles, source, context));
  notes.insert(notes.end(), chosen.notes.begin(), chosen.notes.end());
  points::FieldOptions options = convert::field_options(source, std::nullopt);
  options.spacing = chosen.spacing;
  return convert::make_particle_field(particles, convert::Positions::free, options, context);
}

}  // namespace

Result<MeasuredParticles> measure_particles(const convert::SourceOptions& source, const Context& context) {
  convert::SourceOptions asked = source;
  MeasuredParticles measured;
  ParticleReport& report = measured.report;
  Stopwatch reading;
  auto described = particle_io::describe_particles(asked.input, convert::particle_read_options(asked), context);
  report.read_seconds = reading.elapsed().wall_seconds;
  if (!described) return tl::unexpected(std::move(described.error()));
  report.info = std::move(described->info);
  report.frame = described->frame;
  for (const particle_io::ParticleFormatDescription& about : particle_io::particle_format_descriptions()) {
    if (about.id == report.info.format) report.title = about.title;
  }
  particle_io::ParticleFile& file = described->file;
  report.particles = file.particles.size();
  if (const auto count = TRY(convert::keep_chosen(file.particles, asked.particles, context))) {
    report.chosen = count->chosen;
  }
  TRY(convert::give_element_radii(file, asked, context));
  report.notes = file.notes;
  for (const Note& note : report.info.notes) {
    if (std::ranges::find(report.notes, note) == report.notes.end()) report.notes.push_back(note);
  }
  report.words = words_of_particles(file.particles);
  file.particles.words.clear();
  TRY(convert::apply_box_options(asked.particles.simulation_box, file.particles));
  report.box = file.particles.box;
  report.attributes = ranges_of(report.info.quantities, file.particles);
  std::erase_if(file.particles.attributes, [](const points::ParticleAttribute& attribute) {
    return std::ranges::find(points::kRadiusAttributes, attribute.name) == points::kRadiusAttributes.end();
  });
  report.statistics = TRY(points::measure_statistics(file.particles, context));
  report.method = asked.particles.method;
  asked.particles.non_finite = points::NonFiniteParticles::skip;
  Stopwatch making;
  auto made = measured_field(file.particles, asked, report.notes, context);
  if (!made) {
    if (made.error().code == ErrorCode::cancelled) return tl::unexpected(std::move(made.error()));
    report.no_field = std::move(made.error());
    return measured;
  }
  report.field_seconds = making.elapsed().wall_seconds;
  report.figures = made->figures;
  made->field.creator = file.creator;
  for (const Note& note : made->field.notes) report.notes.push_back(note);
  if (made->figures.particles > 0) measured.field = std::move(made->field);
  return measured;
}

void add_particles(NamedLines& lines, const ParticleReport& report) {
  lines.add("format", fmt::format("{}: {}", report.info.format, report.title));
  lines.add("particles", report.chosen ? fmt::format("{} of {} chosen", *report.chosen, report.particles)
                                       : fmt::format("{}", report.particles));
  if (report.info.frames > 1) {
    lines.add("frames", fmt::format("{}, counted from 0; this report describes {}, choose another with --volume K",
                                    report.info.frames, report.frame.value_or(0)));
  }
  if (report.info.frames > 1) {
    if (const auto steps = range_of(report.info.times, &FrameTime::step)) {
      lines.add("steps", fmt::format("{} to {}", steps->first, steps->second));
    }
    if (const auto times = range_of(report.info.times, &FrameTime::time)) {
      lines.add("times", fmt::format("{:.6g} to {:.6g}", times->first, times->second));
    }
  }
  if (!report.info.frame_name.empty()) lines.add("frame", printable(report.info.frame_name, kShownName));
  const points::ParticleBounds& bounds = report.statistics.bounds;
  if (bounds.finite > 0) lines.add("bounds", convert::box_text(bounds.box));
  if (report.box) {
    lines.add("box", points::box_text(*report.box));
    lines.add("periodic", points::periodic_text(*report.box));
  }
  if (!report.info.length_unit.empty()) lines.add("unit", printable(report.info.length_unit, kShownName));
  if (bounds.not_finite > 0) {
    lines.add("not finite", fmt::format("{}; skip them with --nan outside", counted(bounds.not_finite, "particle")));
  }
  if (const auto& neighbors = report.statistics.neighbors) {
    lines.add("neighbors", fmt::format("nearest at {:.6g} .. {:.6g}, median {:.6g}, of {}", neighbors->min,
                                       neighbors->max, neighbors->median, counted(neighbors->asked, "particle")));
  }
  if (report.statistics.suggested_radius) {
    lines.add("radius",
              fmt::format("{:.6g}: fits the density of the particles; radii in the file or --radius R take precedence",
                          *report.statistics.suggested_radius));
  }
  add_attributes(lines, report.attributes, report.words);
  add_field(lines, report);
}

convert::Json json_of(const ParticleReport& report) {
  const points::ParticleBounds& bounds = report.statistics.bounds;
  convert::Json json{{"format", report.info.format},
                     {"count", report.particles},
                     {"chosen", convert::optional_json(report.chosen)},
                     {"frames", report.info.frames},
                     {"steps", range_json(range_of(report.info.times, &FrameTime::step))},
                     {"times", range_json(range_of(report.info.times, &FrameTime::time))},
                     {"frame", convert::optional_json(report.frame)},
                     {"frame_name", report.info.frame_name},
                     {"length_unit", report.info.length_unit},
                     {"finite", bounds.finite},
                     {"not_finite", bounds.not_finite},
                     {"read_seconds", report.read_seconds}};
  json["bounds"] = bounds.finite > 0 ? convert::json_of(bounds.box) : convert::Json(nullptr);
  json["box"] = nullptr;
  if (report.box) {
    const auto& [origin, edges, periodic] = *report.box;
    json["box"] = {{"origin", convert::json_of(origin)},
                   {"edges", {convert::json_of(edges[0]), convert::json_of(edges[1]), convert::json_of(edges[2])}},
                   {"periodic", periodic}};
  }
  json["neighbors"] = nullptr;
  if (const auto& neighbors = report.statistics.neighbors) {
    json["neighbors"] = {
        {"asked", neighbors->asked}, {"min", neighbors->min}, {"median", neighbors->median}, {"max", neighbors->max}};
  }
  json["suggested_radius"] = convert::optional_json(report.statistics.suggested_radius);
  json["attributes"] = convert::Json::array();
  for (const AttributeRange& range : report.attributes) {
    convert::Json counts = nullptr;
    const auto words = std::ranges::find(report.words, range.quantity.name, &WordCounts::name);
    if (words != report.words.end()) {
      counts = convert::Json::array();
      for (const auto& [word, count] : words->counts) counts.push_back({{"word", word}, {"count", count}});
    }
    json["attributes"].push_back({{"name", range.quantity.name},
                                  {"type", range.quantity.type},
                                  {"components", range.quantity.components},
                                  {"unit", range.quantity.unit},
                                  {"numeric", range.read},
                                  {"min", convert::optional_json(range.min)},
                                  {"max", convert::optional_json(range.max)},
                                  {"not_finite", range.not_finite},
                                  {"words", std::move(counts)}});
  }
  json["method"] = word_of(report.method);
  json["field"] = nullptr;
  if (report.figures) {
    json["field"] = {{"radius", report.figures->radius},
                     {"spacing", report.figures->spacing},
                     {"support", report.figures->support},
                     {"bricks", report.figures->bricks_stored},
                     {"seconds", report.field_seconds}};
  }
  if (report.no_field) {
    json["no_field"] = {{"message", report.no_field->message}, {"hint", hint_text(report.no_field->hint)}};
  }
  json["notes"] = convert::json_of_notes(report.notes);
  return json;
}

}  // namespace isoextract::cli
