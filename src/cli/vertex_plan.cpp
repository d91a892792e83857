#include "cli/vertex_plan.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/nearest_name.hpp"
#include "base/printable.hpp"
#include "cli/plan_parts.hpp"
#include "cli/values.hpp"
#include "convert/attribute_source.hpp"
#include "field/demo_field.hpp"
#include "files/frame_pattern.hpp"
#include "files/output_file.hpp"

namespace isoextract::cli {
namespace {

// The word that selects coloring by iso value.
constexpr std::string_view kIso = "iso";

std::vector<std::string> colormap_names() {
  std::vector<std::string> names;
  for (const auto& word : words_of(edit::Colormap{})) names.emplace_back(word.word);
  return names;
}

// Parses two numbers; nullopt for anything else.
std::optional<std::array<double, 2>> parse_range(std::string_view text) {
  const auto numbers = parse_numbers(text);
  if (!numbers || numbers->size() != 2) return std::nullopt;
  return std::array{(*numbers)[0], (*numbers)[1]};
}

// The settings of an attribute, given after its name as KEY=VALUE.
constexpr std::array<std::string_view, 5> kSettings{"spacing", "origin", "nodata", "volume", "component"};

template <class T>
Result<void> put_setting(std::string_view key, std::string_view text, Result<T> (*parse)(std::string_view),
                         std::optional<T>& target) {
  auto value = parse(text);
  if (!value) return fail(ErrorCode::usage, fmt::format("{}: {}", key, value.error().message), value.error().hint);
  if (target) return fail(ErrorCode::usage, fmt::format("{}= occurs twice", key));
  target = *value;
  return {};
}

std::vector<std::string> kind_names() {
  std::vector<std::string> names;
  for (const auto& word : words_of(AttributeKind{})) names.emplace_back(word.word);
  return names;
}

// Returns whether `word` is a kind, and sets it in `choice`. Refuses words close to a kind as typing errors, since
// names rarely have colons.
Result<bool> take_kind(std::string_view word, convert::AttributeChoice& choice) {
  const auto kind = value_of<AttributeKind>(word);
  if (kind && choice.kind)
    return fail(ErrorCode::usage, fmt::format("expected one attribute kind ({}), found a second one '{}'",
                                              fmt::join(kind_names(), ", "), word));
  if (kind) choice.kind = kind;
  if (kind) return true;
  const std::string near = nearest_name(word, kind_names());
  if (near.empty()) return false;
  return fail(
      ErrorCode::usage,
      fmt::format("expected an attribute kind ({}) after the colon, found '{}'", fmt::join(kind_names(), ", "), word),
      fmt::format("did you mean '{}'?", near));
}

// Returns whether `word` is a setting, and sets it in `choice`.
Result<bool> take_setting(std::string_view word, convert::AttributeChoice& choice) {
  const std::size_t equals = word.find('=');
  if (equals == std::string_view::npos) return false;
  const std::string_view key = word.substr(0, equals);
  const std::string_view value = word.substr(equals + 1);
  Result<void> put;
  if (key == kSettings[0]) {
    put = put_setting(key, value, parse_spacing, choice.spacing);
  } else if (key == kSettings[1]) {
    put = put_setting(key, value, parse_vector, choice.origin);
  } else if (key == kSettings[2]) {
    put = put_setting(key, value, parse_number, choice.no_data);
  } else if (key == kSettings[3]) {
    put = put_setting(key, value, parse_volume_number, choice.volume);
  } else if (key == kSettings[4]) {
    put = put_setting(key, value, parse_component, choice.component);
  } else {
    const std::string near = nearest_name(key, {kSettings.begin(), kSettings.end()});
    if (near.empty()) return false;
    put = fail(ErrorCode::usage,
               fmt::format("expected one of {} before '=', found '{}'", fmt::join(kSettings, ", "), key),
               fmt::format("did you mean '{}'?", near));
  }
  if (!put) return tl::unexpected(std::move(put.error()));
  return true;
}

// Removes words after colons from the end of `text` as long as take(word), a Result<bool>, accepts them.
template <class F>
Result<void> take_from_end(std::string_view& text, F&& take) {
  for (std::size_t colon = text.rfind(':'); colon != std::string_view::npos; colon = text.rfind(':')) {
    const auto taken = TRY(take(text.substr(colon + 1)));
    if (!taken) break;
    text = text.substr(0, colon);
  }
  return {};
}

// Parses NAME[?][=FROM].
Result<void> take_name(std::string_view text, convert::AttributeChoice& choice) {
  const std::size_t equals = text.find('=');
  std::string_view name = text.substr(0, equals);
  choice.optional = name.ends_with('?');
  if (choice.optional) name.remove_suffix(1);
  choice.name = name;
  choice.from = equals == std::string_view::npos ? name : text.substr(equals + 1);
  if (choice.name.empty() || choice.from.empty()) {
    return fail(ErrorCode::usage, fmt::format("expected NAME or NAME=FROM, found '{}'", text));
  }
  if (choice.from.ends_with('?')) {
    return fail(ErrorCode::usage,
                fmt::format("expected the '?' of an optional attribute right after the name, found '{}'", text),
                fmt::format("{}?={}", choice.name, choice.from.substr(0, choice.from.size() - 1)));
  }
  return {};
}

Result<void> check_name_of_map(std::string_view text, edit::Colormap map) {
  const std::size_t colon = text.rfind(':');
  const std::string_view from = text.substr(std::min(text.find('='), text.size()));
  // Paths and demo fields can contain colons.
  if (colon == std::string_view::npos || !from.empty()) return {};
  const std::string word(text.substr(colon + 1));
  if (parse_range(word)) {
    return fail(ErrorCode::usage, fmt::format("expected the range after the color map, found {} before it", word),
                fmt::format("as in {}:{}:{}", printable(text.substr(0, colon)), word_of(map), printable(word)));
  }
  const std::string near = nearest_name(word, colormap_names());
  return fail(ErrorCode::usage,
              fmt::format("expected a color map ({}) or MIN,MAX after the colon, found '{}'",
                          fmt::join(colormap_names(), ", "), word),
              near.empty() ? "" : fmt::format("did you mean '{}'?", near));
}

Result<void> check_formats(const ConvertFlags& flags, const mesh_io::MeshFormatInfo& format) {
  const bool of_vertices = flags.color && flags.color->attribute;
  if ((!flags.attributes.empty() || of_vertices) && !format.has_attributes) {
    std::vector<std::string_view> names;
    for (const mesh_io::MeshFormatInfo& info : mesh_io::mesh_formats()) {
      if (info.has_attributes) names.push_back(info.name);
    }
    return refuse_usage(
        fmt::format("{}: {} cannot store vertex attributes",
                    flags.attributes.empty() ? flags.color.name() : flags.attributes.name(), format.name),
        fmt::format("{} can store vertex attributes", fmt::join(names, ", ")));
  }
  const bool of_surfaces = flags.color && !flags.color->attribute;
  if ((of_surfaces || flags.opacity) && !is_gltf(format.format)) {
    return refuse_usage(fmt::format("{}: {} cannot store materials",
                                    of_surfaces ? flags.color.name() + " iso" : flags.opacity.name(), format.name),
                        "glb and gltf can store materials");
  }
  return {};
}

}  // namespace

Result<convert::AttributeChoice> parse_attribute(std::string_view text) {
  convert::AttributeChoice choice;
  TRY(take_from_end(text, [&](std::string_view word) {
    return word.find('=') == std::string_view::npos ? take_kind(word, choice) : take_setting(word, choice);
  }));
  TRY(take_name(text, choice));
  return choice;
}

Result<ColorFlag> parse_color(std::string_view text) {
  ColorFlag flag;
  convert::AttributeChoice choice;
  bool has_map = false;
  const auto take = [&](std::string_view word) -> Result<bool> {
    const auto map = value_of<edit::Colormap>(word);
    const auto range = parse_range(word);
    if (map && !has_map) {
      has_map = true;
      flag.map = *map;
      return true;
    }
    if (range && !flag.range && !has_map) {
      flag.range = range;
      return true;
    }
    if (value_of<AttributeKind>(word)) {
      return fail(
          ErrorCode::usage,
          fmt::format("'{}' has no effect in --color-by: the kind of an attribute says how its values rotate and scale "
                      "with the mesh, but colors show the values as read",
                      word),
          "give the kind to --attribute, and leave it out of --color-by");
    }
    return take_setting(word, choice);
  };
  TRY(take_from_end(text, take));
  if (flag.range && !((*flag.range)[0] < (*flag.range)[1])) {
    return fail(ErrorCode::usage,
                fmt::format("expected MIN below MAX, found {} and {}", (*flag.range)[0], (*flag.range)[1]));
  }
  TRY(check_name_of_map(text, flag.map));
  if (text == kIso) {
    if (choice == convert::AttributeChoice()) return flag;
    return fail(ErrorCode::usage,
                fmt::format("{} colors surfaces by iso value and takes no {}", kIso, fmt::join(kSettings, ", ")));
  }
  TRY(take_name(text, choice));
  flag.attribute = std::move(choice);
  return flag;
}

Result<std::vector<double>> parse_opacity(std::string_view text) {
  auto values = parse_numbers(text);
  if (!values || !std::ranges::all_of(*values, [](double value) { return value > 0 && value <= 1; })) {
    return fail(ErrorCode::usage, fmt::format("expected numbers above 0 and at most 1, found '{}'", text));
  }
  return std::move(*values);
}

Result<void> plan_vertices(const ConvertFlags& flags, std::size_t isos, convert::ConversionJob& job) {
  TRY(check_formats(flags, mesh_io::mesh_format_info(job.meshes().format)));
  std::vector<convert::AttributeChoice>& attributes = job.source.attributes;
  attributes = flags.attributes;
  std::set<std::string_view> seen;
  for (const convert::AttributeChoice& choice : attributes) {
    if (!seen.insert(choice.name).second) {
      return refuse_usage(fmt::format("--attribute {} occurs twice", choice.name));
    }
  }
  job.opacity = flags.opacity.value_or(job.opacity);
  if (job.opacity.size() > 1 && (flags.batch.iso_table || job.opacity.size() != isos)) {
    return refuse_usage(
        fmt::format("--opacity: expected one value, or one for each number of --iso or --labels, found {}",
                    job.opacity.size()),
        "give one value for all surfaces, or the values in the order of --iso or --labels");
  }
  if (!flags.color) return {};
  job.color = convert::ColorChoice{{}, flags.color->map, flags.color->range};
  if (!flags.color->attribute) return {};
  convert::AttributeChoice wanted = *flags.color->attribute;
  job.color->attribute = wanted.name;
  // The name alone refers to the attribute of --attribute, or of a mesh file.
  convert::AttributeChoice name_alone;
  name_alone.name = name_alone.from = wanted.name;
  if (job.source.mesh) {
    if (wanted == name_alone) return {};
    return refuse_usage("the input is a mesh, so --color-by takes no =FROM, '?' or settings of the attribute",
                        fmt::format("use --color-by {}, with :MAP and :MIN,MAX if you like", wanted.name));
  }
  const auto same = std::ranges::find(attributes, wanted.name, &convert::AttributeChoice::name);
  if (same == attributes.end()) {
    wanted.written = false;
    attributes.push_back(std::move(wanted));
    return {};
  }
  if (wanted == name_alone || wanted == *same) return {};
  if (wanted.from == same->from) {
    return refuse_usage(
        fmt::format("--attribute and --color-by give different settings for '{}'", wanted.name),
        fmt::format("give the settings to --attribute, and only the name to --color-by {}", wanted.name));
  }
  return refuse_usage(fmt::format("'{}' stands for '{}' in --attribute and for '{}' in --color-by", wanted.name,
                                  same->from, wanted.from),
                      "give one of the two another name");
}

Result<void> number_attributes(std::vector<convert::AttributeChoice>& attributes, std::int64_t frame) {
  for (convert::AttributeChoice& choice : attributes) {
    const convert::AttributeLocation place = convert::attribute_location(choice);
    if (place.file.empty() || place.file.starts_with(field::kDemoPrefix) || files::is_there(place.file)) continue;
    const auto pattern = TRY(files::FramePattern::parse(place.file));
    if (!pattern) continue;
    choice.from = pattern->expand(frame) + (place.grid ? fmt::format("[{}]", *place.grid) : "");
  }
  return {};
}

}  // namespace isoextract::cli
