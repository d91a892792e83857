// A scalar field: samples, what their values mean, and where they are in the world.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/words.hpp"
#include "field/affine.hpp"
#include "field/samples.hpp"

namespace isoextract::field {

enum class FieldKind {
  density,    // inside is value > iso
  level_set,  // inside is value < iso
};
// By the side that is inside.
constexpr auto words_of(FieldKind /*type*/) {
  return std::array{Word{FieldKind::density, "above"}, Word{FieldKind::level_set, "below"}};
}

// What a stored number stands for: value = slope * stored + intercept (NIfTI scl_slope and scl_inter).
struct ValueScale {
  double slope = 1;
  double intercept = 0;

  [[nodiscard]] double operator()(double stored) const { return is_identity() ? stored : slope * stored + intercept; }
  [[nodiscard]] bool is_identity() const { return slope == 1 && intercept == 0; }
};

struct ScalarField {
  std::string name;         // of the grid, or the file's stem where the format has no names
  std::string source;       // the path or demo: text it was read from, for messages
  std::string format;       // "OpenVDB", "NRRD", ...
  std::string world_space;  // what the file calls its world: "RAS", "left-posterior-superior", ...; may be empty
  std::string length_unit;  // what the file calls the unit of that world: "mm", "microns", ...; may be empty
  std::string creator;      // what made it, as the file or its format says: "Houdini/SOP_OpenVDB_Write"; may be empty
  std::size_t grids = 0;    // how many the source has by name, this one among them; 0 where its format names none
  std::string grid;         // where it does: what no other of them is called; printable
  FieldKind kind = FieldKind::density;
  ValueScale scale;
  Affine index_to_world;  // of sample centres: index (i, j, k) is the position of that sample
  Affine index_to_file;   // where that sample is among the file's, whose indices are voxel coordinates: the identity
                          // unless the field was resampled or made coarser
  Samples samples;
  std::vector<std::string> notes;  // what the reader left out or assumed, one sentence each; `cli` shows them

  [[nodiscard]] SampleType type() const {
    return std::visit([](const auto& s) { return s.type; }, samples);
  }
  // Dense: every sample. Sparse: the active voxels.
  [[nodiscard]] IndexBox extents() const {
    if (const auto* dense = std::get_if<DenseSamples>(&samples)) return {glm::ivec3(0), dense->dims - 1};
    return std::get<SparseSamples>(samples).active_box;
  }
};

}  // namespace isoextract::field
