#include "convert/iso_choice.hpp"

#include <fmt/format.h>

#include "convert/json_values.hpp"

namespace isoextract::convert {
namespace {

constexpr std::string_view kSuggested = "auto";
constexpr std::string_view kZero = "zero";
constexpr char kPercentile = 'p';
constexpr std::string_view kLabel = "label ";
constexpr std::string_view kAllLabels = "all labels";

}  // namespace

IsoChoice IsoChoice::suggested() {
  IsoChoice choice;
  choice.kind = Kind::suggested;
  return choice;
}

IsoChoice IsoChoice::zero() {
  IsoChoice choice;
  choice.kind = Kind::zero;
  return choice;
}

IsoChoice IsoChoice::percentile(field::Percent percent) {
  IsoChoice choice;
  choice.kind = Kind::percentile;
  choice.percent = percent;
  return choice;
}

IsoChoice IsoChoice::label(std::int64_t number) {
  IsoChoice choice;
  choice.kind = Kind::label;
  choice.number = static_cast<double>(number);
  return choice;
}

IsoChoice IsoChoice::all_labels() {
  IsoChoice choice;
  choice.kind = Kind::all_labels;
  return choice;
}

std::string text_of(const IsoChoice& choice) {
  switch (choice.kind) {
    case IsoChoice::Kind::number: break;
    case IsoChoice::Kind::suggested: return std::string(kSuggested);
    case IsoChoice::Kind::zero: return std::string(kZero);
    case IsoChoice::Kind::percentile: return kPercentile + choice.percent.text();
    case IsoChoice::Kind::label: return fmt::format("{}{}", kLabel, choice.number);
    case IsoChoice::Kind::all_labels: return std::string(kAllLabels);
  }
  return fmt::format("{}", choice.number);
}

std::string name_part_of(const IsoChoice& choice) {
  return choice.kind == IsoChoice::Kind::label ? fmt::format("{}", choice.number) : text_of(choice);
}

Json json_of(const IsoChoice& choice) { return choice.is_number() ? Json(choice.number) : Json(text_of(choice)); }

std::optional<IsoChoice> iso_choice_of(std::string_view word) {
  if (word == kSuggested) return IsoChoice::suggested();
  if (word == kZero) return IsoChoice::zero();
  if (!word.starts_with(kPercentile)) return std::nullopt;
  const auto percent = field::Percent::parse(word.substr(1));
  if (!percent) return std::nullopt;
  return IsoChoice::percentile(*percent);
}

}  // namespace isoextract::convert
