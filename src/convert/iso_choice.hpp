// Which surface it is: that at an iso value, or that of a label. And which one is asked for, where the field may
// decide.
#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "convert/json_type.hpp"
#include "field/percentiles.hpp"

namespace isoextract::convert {

enum class Label : std::int64_t {};  // its number in a label map

class SurfaceId {
 public:
  SurfaceId() = default;
  SurfaceId(double iso) : of_(iso) {}     // NOLINT(google-explicit-constructor): iso values are the rule
  SurfaceId(Label label) : of_(label) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool is_label() const { return std::holds_alternative<Label>(of_); }
  // Each throws where it is the other.
  [[nodiscard]] double iso() const { return std::get<double>(of_); }
  [[nodiscard]] std::int64_t label() const { return static_cast<std::int64_t>(std::get<Label>(of_)); }
  // The iso value, or the label as a number: what reports list.
  [[nodiscard]] double figure() const { return is_label() ? static_cast<double>(label()) : iso(); }
  [[nodiscard]] std::string text() const;  // "0.3", "5"
  [[nodiscard]] std::string name() const;  // "iso 0.3", "label 5"

  friend bool operator==(const SurfaceId&, const SurfaceId&) = default;
  // NOLINTNEXTLINE(modernize-use-nullptr): there is none
  friend auto operator<=>(const SurfaceId&, const SurfaceId&) = default;

 private:
  std::variant<double, Label> of_ = 0.0;
};

struct IsoChoice {
  enum class Kind {
    known,       // a number, or the voxels with a number in a label map
    suggested,   // field::suggest_iso(), of particles the usual value of their method
    zero,        // 0 of a level set, refused for other fields: what is taken where no iso value is given
    percentile,  // of the samples that are read: all of them, whatever part or grid is extracted from
    all_labels,  // each label of a label map
  };
  Kind kind = Kind::known;
  SurfaceId id;            // of a known one; an iso value is finite
  field::Percent percent;  // of a percentile

  IsoChoice() = default;
  IsoChoice(double iso) : id(iso) {}  // NOLINT(google-explicit-constructor): numbers are the rule
  [[nodiscard]] static IsoChoice suggested() { return IsoChoice(Kind::suggested); }
  [[nodiscard]] static IsoChoice zero() { return IsoChoice(Kind::zero); }
  [[nodiscard]] static IsoChoice percentile(field::Percent percent) { return IsoChoice(Kind::percentile, {}, percent); }
  [[nodiscard]] static IsoChoice label(std::int64_t number) { return IsoChoice(Kind::known, Label{number}); }
  [[nodiscard]] static IsoChoice all_labels() { return IsoChoice(Kind::all_labels); }

  [[nodiscard]] bool is_number() const { return kind == Kind::known && !id.is_label(); }
  [[nodiscard]] bool is_label() const { return kind == Kind::all_labels || id.is_label(); }
  // Whether the field that is read decides which value that is.
  [[nodiscard]] bool is_found() const {
    return kind == Kind::suggested || kind == Kind::zero || kind == Kind::percentile;
  }

  friend bool operator==(const IsoChoice&, const IsoChoice&) = default;
  // NOLINTNEXTLINE(modernize-use-nullptr): there is none
  friend auto operator<=>(const IsoChoice&, const IsoChoice&) = default;

 private:
  explicit IsoChoice(Kind chosen, SurfaceId known = {}, field::Percent share = {})
      : kind(chosen), id(known), percent(share) {}
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
