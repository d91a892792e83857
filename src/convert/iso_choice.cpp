#include "convert/iso_choice.hpp"

#include <fmt/format.h>

#include "convert/json_values.hpp"

namespace isoextract::convert {
namespace {

constexpr std::string_view kSuggested = "auto";
constexpr std::string_view kZero = "zero";
constexpr char kPercentile = 'p';
constexpr std::string_view kAllLabels = "all labels";

}  // namespace

std::string SurfaceId::text() const { return is_label() ? fmt::format("{}", label()) : fmt::format("{}", iso()); }
std::string SurfaceId::name() const { return (is_label() ? "label " : "iso ") + text(); }

std::string text_of(const IsoChoice& choice) {
  switch (choice.kind) {
    case IsoChoice::Kind::known: break;
    case IsoChoice::Kind::suggested: return std::string(kSuggested);
    case IsoChoice::Kind::zero: return std::string(kZero);
    case IsoChoice::Kind::percentile: return kPercentile + choice.percent.text();
    case IsoChoice::Kind::all_labels: return std::string(kAllLabels);
    case IsoChoice::Kind::selected_labels: return "labels " + choice.selection;
  }
  return choice.id.is_label() ? choice.id.name() : choice.id.text();
}

std::string file_name_part(const IsoChoice& choice) {
  return choice.kind == IsoChoice::Kind::known ? choice.id.text() : text_of(choice);
}

Json json_of(const SurfaceId& id) { return id.is_label() ? Json(id.label()) : Json(id.iso()); }

SurfaceId surface_id_of(const Json& json) {
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
