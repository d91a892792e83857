#include "convert/iso_choice.hpp"

#include <fmt/format.h>

namespace isoextract::convert {
namespace {

constexpr std::string_view kSuggested = "auto";
constexpr char kPercentile = 'p';

}  // namespace

IsoChoice IsoChoice::suggested() {
  IsoChoice choice;
  choice.kind = Kind::suggested;
  return choice;
}

IsoChoice IsoChoice::percentile(field::Percent percent) {
  IsoChoice choice;
  choice.kind = Kind::percentile;
  choice.percent = percent;
  return choice;
}

std::string text_of(const IsoChoice& choice) {
  switch (choice.kind) {
    case IsoChoice::Kind::number: break;
    case IsoChoice::Kind::suggested: return std::string(kSuggested);
    case IsoChoice::Kind::percentile: return kPercentile + choice.percent.text();
  }
  return fmt::format("{}", choice.number);
}

Json json_of(const IsoChoice& choice) { return choice.is_number() ? Json(choice.number) : Json(text_of(choice)); }

std::optional<IsoChoice> iso_choice_of(std::string_view word) {
  if (word == kSuggested) return IsoChoice::suggested();
  if (!word.starts_with(kPercentile)) return std::nullopt;
  const auto percent = field::Percent::parse(word.substr(1));
  if (!percent) return std::nullopt;
  return IsoChoice::percentile(*percent);
}

}  // namespace isoextract::convert
