// A scalar field: its samples, the meaning of their values, and its placement in the world.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "base/enum_words.hpp"
#include "base/note.hpp"
#include "field/affine.hpp"
#include "field/samples.hpp"

namespace isoextract::field {

enum class FieldKind {
  density,    // inside is value > iso
  level_set,  // inside is value < iso
};
// Returns the words for options and reports; each names the side of the iso value that is inside.
constexpr auto words_of(FieldKind /*type*/) {
  return std::array{Word{FieldKind::density, "above"}, Word{FieldKind::level_set, "below"}};
}

// The value that a stored number represents: slope * stored + intercept (NIfTI scl_slope and scl_inter).
struct ValueScale {
  double slope = 1;
  double intercept = 0;

  [[nodiscard]] double operator()(double stored) const { return is_identity() ? stored : slope * stored + intercept; }
  [[nodiscard]] bool is_identity() const { return slope == 1 && intercept == 0; }
};

// A label of a label map, as its file names it.
struct LabelName {
  std::int64_t label = 0;
  std::string name;
  std::optional<glm::dvec3> color;  // sRGB, each channel from 0 to 1; if the file recommends one
  // The number of the volume that has this label, if the volumes are layers of one label map. Labels of different
  // layers may overlap, and may have the same number. Without layers: nullopt.
  std::optional<std::int64_t> layer;

  friend bool operator==(const LabelName&, const LabelName&) = default;
};

// The distinct ids of a label map, which its samples index: 0, then the others in ascending order. Null: the samples
// are the ids. 64-bit ids are not stored as double, which cannot hold all of them.
using LabelIdTable = std::shared_ptr<const std::vector<std::int64_t>>;

// Chunks, slices or files of which a reader needed only some.
struct PartsRead {
  std::uint64_t read = 0;
  std::uint64_t of = 0;  // 0 if the file has no parts

  friend bool operator==(const PartsRead&, const PartsRead&) = default;
};

struct ScalarField {
  std::string name;         // of the grid, or the file's stem if the format has no names
  std::string source;       // name of the input for messages: path, "standard input", or a text like "demo:sphere"
  std::string format;       // "OpenVDB", "NRRD", ...
  std::string world_space;  // the file's name for its world space: "RAS", "left-posterior-superior", ...; may be empty
  std::string length_unit;  // the file's name for the unit of that space: "mm", "microns", ...; may be empty
  std::string creator;      // the program that made the file: "Houdini/SOP_OpenVDB_Write"; may be empty
  std::size_t grids = 0;    // number of named grids in the source, including this one; 0 if its format names none
  std::string grid;         // the grid's label (GridInfo::label), unique in the file; empty if `grids` is 0
  FieldKind kind = FieldKind::density;
  ValueScale scale;
  Affine index_to_world;  // maps index (i, j, k) to the center of that sample
  Affine index_to_file;   // maps index (i, j, k) to the sample indices of the file (voxel coordinates); the identity
                          // unless the reader cropped or shifted the samples, or the field was resampled or coarsened
  Samples samples;
  std::vector<LabelName> labels;  // the labels that a label map's file names, of all layers, in ascending order
  LabelIdTable label_ids;         // if set, the samples are u32 indices (ReadOptions::label_ids)
  std::optional<double> time;     // of the volume, in units of time_unit; if the file states it
  std::string time_unit;          // "s", "days since 1950-01-01"; may be empty
  PartsRead parts;
  bool is_sampled = false;  // the reader sampled other data, such as an unstructured grid, at the spacing it was given
  Notes notes;              // omissions and assumptions of the reader, one sentence each; `cli` prints them

  [[nodiscard]] SampleType type() const {
    return std::visit([](const auto& s) { return s.type; }, samples);
  }
  // Returns the box of all samples (dense) or of the active voxels (sparse).
  [[nodiscard]] IndexBox extents() const {
    if (const auto* dense = std::get_if<DenseSamples>(&samples)) return {glm::ivec3(0), dense->dims - 1};
    return std::get<SparseSamples>(samples).active_box;
  }
};

}  // namespace isoextract::field
