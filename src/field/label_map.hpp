// Judges whether the samples of a field are labels or a binary mask, and measures each label.
//
// A field can be a label map or a binary mask if it is a density with an identity scale, and no demo field. It must
// have at least 512 samples, all of them labels (label_value.hpp) or NaN. The rules that follow leave out NaN samples.
// Sparse floating-point grids are neither: fog often has one value inside, and would look like a mask.
//
// A binary mask has exactly two values; the background of a sparse grid is one of them. A label map has more, and:
// - few values: at most 2^20, and at most one for each eight samples
// - flat patches: of the pairs of neighbors along i, j and k, at least half have equal values, and along each axis at
//   least a quarter. Pairs of two samples of the most frequent value (in a sparse grid: of its background) do not
//   count.
// - unordered values, if it has more than eight: of the pairs with different values, at most three quarters differ by
//   exactly 1. A smooth field with rounded values has flat patches, too, but steps of 1 between them.
//
// Limits. A scan in eight or fewer classes is a label map, whatever the classes mean; so is a smooth field with eight
// or fewer values. Noise of two values is a mask. Labels that are mostly one sample thick fail for lack of flat
// patches, and a stack of more than eight layers that are numbered in order fails for its steps of 1. In scans, about a
// tenth of the pairs are equal (at most 13 % in eight scans of 8 and 16 bits). In a map of 3,000 Voronoi cells in 64^3
// samples, 71 % are equal.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/enum_words.hpp"
#include "base/progress.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

enum class LabelMapKind { binary_mask, label_map };
constexpr auto words_of(LabelMapKind /*type*/) {
  return std::array{Word{LabelMapKind::binary_mask, "binary mask"}, Word{LabelMapKind::label_map, "label map"}};
}

struct LabelFigures {
  std::int64_t label = 0;
  std::uint64_t voxels = 0;
  IndexBox box;  // of its voxels

  friend bool operator==(const LabelFigures&, const LabelFigures&) = default;
};

struct LabelMap {
  LabelMapKind kind = LabelMapKind::label_map;
  // The labels with a mesh: all but 0 and the background of a sparse grid. In ascending order; at least one.
  std::vector<LabelFigures> labels;
  std::optional<LabelFigures> background;  // the label 0 of a dense field that has it
  double equal_share = 0;                  // share of equal pairs among the pairs of neighbors that count
  // Faces of voxels between a label and another value or the data boundary, once for each label beside the face. Exact
  // for dense fields. An estimate for sparse fields, which are measured block by block.
  std::uint64_t faces = 0;
};

// Returns the labels of a label map or mask, else nothing. One parallel pass over the samples, linear in their number
// whatever the number of labels. In fields of more than 2^17 samples, it first looks at no more than 2^17 of them. It
// makes no full pass if these samples show that the field has no labels, as most fields do. For 64-bit ids
// (ScalarField::label_ids) it judges by the indices of the ids, and returns the ids. Reserves no memory; takes about
// 150 bytes a label and thread.
[[nodiscard]] std::optional<LabelMap> measure_label_map(const ScalarField& field, Progress* progress = nullptr);

// Judges by at most 2^17 samples, in small boxes all over the field: exact for smaller dense fields. Reads the blocks
// of a sparse field, not its tiles. The cost does not depend on the size of the field. Returns nothing if the field is
// neither a label map nor a mask, or if these samples and the background of a sparse field have one value only. Returns
// nothing either for samples with DenseSamples::layers.
[[nodiscard]] std::optional<LabelMapKind> guess_label_map(const ScalarField& field);

}  // namespace isoextract::field
