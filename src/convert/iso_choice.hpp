// Which iso value is asked for: a number, or one that is found in the field.
#pragma once

#include <compare>
#include <optional>
#include <string>
#include <string_view>

#include "convert/json_values.hpp"
#include "field/percentiles.hpp"

namespace isoextract::convert {

struct IsoChoice {
  enum class Kind {
    number,
    suggested,   // field::suggest_iso(), of particles the usual value of their method
    percentile,  // of the samples that are read: all of them, whatever part or grid is extracted from
  };
  Kind kind = Kind::number;
  double number = 0;       // finite; 0 of other kinds
  field::Percent percent;  // likewise

  IsoChoice() = default;
  IsoChoice(double value) : number(value) {}  // NOLINT(google-explicit-constructor): numbers are the rule
  [[nodiscard]] static IsoChoice suggested();
  [[nodiscard]] static IsoChoice percentile(field::Percent percent);

  [[nodiscard]] bool is_number() const { return kind == Kind::number; }

  friend bool operator==(const IsoChoice&, const IsoChoice&) = default;
  // NOLINTNEXTLINE(modernize-use-nullptr): there is none
  friend auto operator<=>(const IsoChoice&, const IsoChoice&) = default;
};

// The shortest that iso_choice_of() takes: "0.3", "auto", "p99.9".
[[nodiscard]] std::string text_of(const IsoChoice& choice);

// A number as one, else the word.
[[nodiscard]] Json json_of(const IsoChoice& choice);

// "auto" or "p" and a Percent. Nothing for other words, numbers among them.
[[nodiscard]] std::optional<IsoChoice> iso_choice_of(std::string_view word);

}  // namespace isoextract::convert
