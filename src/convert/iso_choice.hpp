// Identifies a surface by its iso value, its label or its number in a mesh file (SurfaceId), and a requested surface
// whose iso value the field may still determine (IsoChoice).
#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "convert/json_type.hpp"
#include "field/percentiles.hpp"

namespace isoextract::convert {

enum class Label : std::int64_t {};  // the number of a label in a label map

// The number of a mesh in a mesh file, counted from 1; kWholeFile stands for all meshes of the file as one.
enum class FileMesh : std::uint64_t {};
inline constexpr FileMesh kWholeFile{0};

class SurfaceId {
 public:
  SurfaceId() = default;
  SurfaceId(double iso) : of_(iso) {}      // NOLINT(google-explicit-constructor): iso values are the rule
  SurfaceId(Label label) : of_(label) {}   // NOLINT(google-explicit-constructor)
  SurfaceId(FileMesh mesh) : of_(mesh) {}  // NOLINT(google-explicit-constructor)
  // Returns the surface of terrain, which has no iso value. Records have the iso value 0 for it, which it equals; texts
  // leave it out.
  [[nodiscard]] static SurfaceId terrain() {
    SurfaceId id = 0.0;
    id.is_terrain_ = true;
    return id;
  }

  [[nodiscard]] bool is_iso() const { return std::holds_alternative<double>(of_); }
  [[nodiscard]] bool is_label() const { return std::holds_alternative<Label>(of_); }
  [[nodiscard]] bool is_file_mesh() const { return std::holds_alternative<FileMesh>(of_); }
  // Returns whether the input has no other surface: terrain, or all meshes of a file as one. Its place() is empty.
  [[nodiscard]] bool is_only_surface() const { return is_terrain_ || of_ == Of(kWholeFile); }
  // iso(), label() and file_mesh() throw std::bad_variant_access if the surface is of another kind.
  [[nodiscard]] double iso() const { return std::get<double>(of_); }
  [[nodiscard]] std::int64_t label() const { return static_cast<std::int64_t>(std::get<Label>(of_)); }
  [[nodiscard]] std::uint64_t file_mesh() const { return static_cast<std::uint64_t>(std::get<FileMesh>(of_)); }
  // Returns the iso value, or 0 for other surfaces, where extraction options need a number that has no effect.
  [[nodiscard]] double iso_or_zero() const { return is_iso() ? iso() : 0; }
  // Returns the iso value or the label, rounded if a double cannot hold it: for colors, not to identify a surface.
  [[nodiscard]] double rounded() const { return is_label() ? static_cast<double>(label()) : iso_or_zero(); }
  [[nodiscard]] std::string text() const;     // "0.3", "5", "mesh 2", "mesh" for kWholeFile, "0" for terrain
  [[nodiscard]] std::string name() const;     // "iso 0.3", "label 5", "mesh 2", "mesh", "terrain"
  [[nodiscard]] std::string at_text() const;  // continues a sentence: " at iso 0.3", " at label 5", " of mesh 2", ""

  friend bool operator==(const SurfaceId& a, const SurfaceId& b) { return a.of_ == b.of_; }
  friend auto operator<=>(const SurfaceId& a, const SurfaceId& b) { return a.of_ <=> b.of_; }

 private:
  using Of = std::variant<double, Label, FileMesh>;
  Of of_ = 0.0;
  bool is_terrain_ = false;
};

struct IsoChoice {
  enum class Kind {
    known,            // a given iso value or label
    suggested,        // field::suggest_iso(); for particles the default value of their method
    zero,             // 0 of a level set; refused for other fields. The default for volumes (`by_default`)
    percentile,       // of all samples read, whatever region or resampling is requested
    all_labels,       // each label of a label map
    selected_labels,  // the labels that a LabelSelection contains
    file_meshes,      // the meshes of a mesh file, each one if the output can hold several, else as one
  };
  Kind kind = Kind::known;
  SurfaceId id;             // of Kind::known; an iso value is finite
  field::Percent percent;   // of Kind::percentile
  std::string selection;    // of Kind::selected_labels: a text that LabelSelection::parse() takes
  bool by_default = false;  // of Kind::zero: the user gave no iso value

  IsoChoice() = default;
  IsoChoice(double iso) : id(iso) {}  // NOLINT(google-explicit-constructor): numbers are the rule
  [[nodiscard]] static IsoChoice suggested() { return IsoChoice(Kind::suggested); }
  [[nodiscard]] static IsoChoice zero() { return IsoChoice(Kind::zero); }
  [[nodiscard]] static IsoChoice terrain() { return IsoChoice(Kind::known, SurfaceId::terrain()); }
  [[nodiscard]] static IsoChoice zero_by_default() {
    IsoChoice choice(Kind::zero);
    choice.by_default = true;
    return choice;
  }
  [[nodiscard]] static IsoChoice percentile(field::Percent percent) { return IsoChoice(Kind::percentile, {}, percent); }
  [[nodiscard]] static IsoChoice label(std::int64_t number) { return IsoChoice(Kind::known, Label{number}); }
  [[nodiscard]] static IsoChoice file_meshes() { return IsoChoice(Kind::file_meshes); }
  [[nodiscard]] static IsoChoice all_labels() { return IsoChoice(Kind::all_labels); }

  [[nodiscard]] static IsoChoice selected_labels(std::string selection) {
    IsoChoice choice(Kind::selected_labels);
    choice.selection = std::move(selection);
    return choice;
  }

  [[nodiscard]] bool is_number() const { return kind == Kind::known && !id.is_label(); }
  [[nodiscard]] bool is_label() const { return is_label_set() || id.is_label(); }
  // Returns whether only the label map tells which labels these are.
  [[nodiscard]] bool is_label_set() const { return kind == Kind::all_labels || kind == Kind::selected_labels; }
  // Returns whether it is a label set of one name. The label map can still have several labels of that name.
  [[nodiscard]] bool is_label_name() const;
  // Returns whether the iso value has to be found in the field.
  [[nodiscard]] bool is_found() const {
    return kind == Kind::suggested || kind == Kind::zero || kind == Kind::percentile;
  }

  friend bool operator==(const IsoChoice&, const IsoChoice&) = default;
  // NOLINTNEXTLINE(modernize-use-nullptr): there is no pointer here to replace
  friend auto operator<=>(const IsoChoice&, const IsoChoice&) = default;

 private:
  explicit IsoChoice(Kind chosen, SurfaceId known = {}, field::Percent share = {})
      : kind(chosen), id(known), percent(share) {}
};

// Returns the shortest text: "0.3", "auto", "zero", "p99.9", "label 5", "all labels", "labels 1-9,!3", "mesh".
[[nodiscard]] std::string text_of(const IsoChoice& choice);

// Returns text_of() as part of a file name; for a label its number alone.
[[nodiscard]] std::string file_name_part(const IsoChoice& choice);

// Returns a floating-point number for an iso value, an integer for a label, SurfaceId::text() for a mesh of a file.
[[nodiscard]] Json json_of(const SurfaceId& id);
// Returns the mesh of a file that SurfaceId::text() describes.
[[nodiscard]] SurfaceId surface_id_of_mesh(std::string_view text);
// Inverts json_of(): a number without fraction is a label only if it is an integer in the JSON text.
[[nodiscard]] SurfaceId surface_id_of(const Json& json);

// Returns a number for an iso value, else the text.
[[nodiscard]] Json json_of(const IsoChoice& choice);

// The values that iso_choice_of() takes beside a number, for messages about another one.
inline constexpr std::string_view kIsoWords = "auto, zero or a percentile from p0 to p100";

// Parses "auto", "zero" or "p" and a Percent. Returns nullopt for other words and for numbers.
[[nodiscard]] std::optional<IsoChoice> iso_choice_of(std::string_view word);

}  // namespace isoextract::convert
