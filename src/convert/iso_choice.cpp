#include "convert/iso_choice.hpp"

#include <charconv>
#include <cstdint>

#include <fmt/format.h>

#include "convert/json_values.hpp"
#include "convert/label_selection.hpp"

namespace isoextract::convert {
namespace {

constexpr std::string_view kSuggested = "auto";
constexpr std::string_view kZero = "zero";
constexpr char kPercentile = 'p';
constexpr std::string_view kAllLabels = "all labels";
constexpr std::string_view kFileMesh = "mesh";

}  // namespace

std::string SurfaceId::text() const {
  if (is_label()) return fmt::format("{}", label());
  if (is_iso()) return fmt::format("{}", iso());
  return *this == kWholeFile ? std::string(kFileMesh) : fmt::format("{} {}", kFileMesh, file_mesh());
}

std::string SurfaceId::name() const {
  if (is_terrain_) return "terrain";
  return (is_label() ? "label " : is_iso() ? "iso " : "") + text();
}

std::string SurfaceId::at_text() const {
  if (is_only_surface()) return {};
  return (is_file_mesh() ? " of " : " at ") + name();
}

SurfaceId surface_id_of_mesh(std::string_view text) {
  const std::size_t digits = text.find_last_of(' ') + 1;
  std::uint64_t number = 0;
  if (digits > 0) std::from_chars(text.data() + digits, text.data() + text.size(), number);
  return FileMesh{number};
}

bool IsoChoice::is_label_name() const {
  const auto labels = kind == Kind::selected_labels ? LabelSelection::parse(selection) : std::nullopt;
  return labels && labels->is_one_name();
}

std::string text_of(const IsoChoice& choice) {
  switch (choice.kind) {
    case IsoChoice::Kind::known: break;
    case IsoChoice::Kind::suggested: return std::string(kSuggested);
    case IsoChoice::Kind::zero: return std::string(kZero);
    case IsoChoice::Kind::percentile: return kPercentile + choice.percent.text();
    case IsoChoice::Kind::all_labels: return std::string(kAllLabels);
    case IsoChoice::Kind::selected_labels: return "labels " + choice.selection;
    case IsoChoice::Kind::file_meshes: return std::string(kFileMesh);
  }
  return choice.id.is_label() ? choice.id.name() : choice.id.text();
}

std::string file_name_part(const IsoChoice& choice) {
  return choice.kind == IsoChoice::Kind::known ? choice.id.text() : text_of(choice);
}

Json json_of(const SurfaceId& id) {
  if (id.is_label()) return id.label();
  return id.is_iso() ? Json(id.iso()) : Json(id.text());
}

SurfaceId surface_id_of(const Json& json) {
  if (json.is_string()) return surface_id_of_mesh(json.get_ref<const std::string&>());
  return json.is_number_integer() ? SurfaceId(Label{json.get<std::int64_t>()}) : SurfaceId(json.get<double>());
}

Json json_of(const IsoChoice& choice) { return choice.is_number() ? Json(choice.id.iso()) : Json(text_of(choice)); }

std::optional<IsoChoice> iso_choice_of(std::string_view word) {
  if (word == kSuggested) return IsoChoice::suggested();
  if (word == kZero) return IsoChoice::zero();
  if (!word.starts_with(kPercentile)) return std::nullopt;
  const auto percent = field::Percent::parse(word.substr(1));
  if (!percent) return std::nullopt;
  return IsoChoice::percentile(*percent);
}

}  // namespace isoextract::convert
