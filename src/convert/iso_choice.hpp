// Which surface is asked for: that of an iso value, a number or one that is found in the field, or that of a label.
#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "convert/json_type.hpp"
#include "field/percentiles.hpp"

namespace isoextract::convert {

struct IsoChoice {
  enum class Kind {
    number,
    suggested,   // field::suggest_iso(), of particles the usual value of their method
    zero,        // 0 of a level set, refused for other fields: what is taken where no iso value is given
    percentile,  // of the samples that are read: all of them, whatever part or grid is extracted from
    label,       // the voxels with this number in a label map
    all_labels,  // each of its labels
  };
  Kind kind = Kind::number;
  double number = 0;       // finite; of a label an integer; 0 of other kinds
  field::Percent percent;  // likewise

  IsoChoice() = default;
  IsoChoice(double value) : number(value) {}  // NOLINT(google-explicit-constructor): numbers are the rule
  [[nodiscard]] static IsoChoice suggested();
  [[nodiscard]] static IsoChoice zero();
  [[nodiscard]] static IsoChoice percentile(field::Percent percent);

  [[nodiscard]] static IsoChoice label(std::int64_t number);
  [[nodiscard]] static IsoChoice all_labels();

  [[nodiscard]] bool is_number() const { return kind == Kind::number; }
  [[nodiscard]] bool is_label() const { return kind == Kind::label || kind == Kind::all_labels; }
  // Whether the field that is read decides which value that is.
  [[nodiscard]] bool is_found() const {
    return kind == Kind::suggested || kind == Kind::zero || kind == Kind::percentile;
  }

  friend bool operator==(const IsoChoice&, const IsoChoice&) = default;
  // NOLINTNEXTLINE(modernize-use-nullptr): there is none
  friend auto operator<=>(const IsoChoice&, const IsoChoice&) = default;
};

// "0.3", "auto", "zero", "p99.9", "label 5", "all labels": the shortest text.
[[nodiscard]] std::string text_of(const IsoChoice& choice);

// The same as a part of a file's name: of a label its number.
[[nodiscard]] std::string name_part_of(const IsoChoice& choice);

// A number as one, else the word.
[[nodiscard]] Json json_of(const IsoChoice& choice);

// "auto", "zero", or "p" and a Percent. Nothing for other words, numbers among them.
[[nodiscard]] std::optional<IsoChoice> iso_choice_of(std::string_view word);

}  // namespace isoextract::convert
