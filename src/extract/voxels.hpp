// Surfaces of voxels: a sample that is inside is a solid box of one index step around it, and the surface is what of
// these boxes is exposed. Samples outside the data or the region are outside, so it is closed everywhere.
//
// Voxels are joined by faces only. Where two touch along an edge or in a corner, each fan of faces has a vertex of its
// own there (detail/corner_fans.hpp), so that the mesh is a closed, oriented 2-manifold whatever the voxels are. Its
// volume is that of the voxels.
//
// Coplanar faces are merged to large rectangles (VoxelFaces), found as in a hash table of voxels from which the exposed
// faces are taken (the voxel surface of the water automaton, see docs/papers.md), with whole words of bits for voxels.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "extract/extractor.hpp"

namespace isoextract::extract {

// Which labels of a label map.
struct LabelChoice {
  bool all = false;                  // but 0, and what a sparse field has all around
  std::vector<std::int64_t> values;  // else these, each once

  friend bool operator==(const LabelChoice&, const LabelChoice&) = default;
};

// Where each label of a label map is, found in one look at the samples.
class LabelVoxels {
 public:
  // Of the region in `options`, whose iso value plays no part; for surface nets with the net of all labels there are,
  // whichever are asked for, so that the choice changes no mesh. What is found is reserved for as long as it lives.
  // Floating-point samples are labels where all of the region are whole numbers, up to which their type has every one;
  // with NanPolicy::outside, NaN has no label.
  // Fails with ErrorCode::usage where a scale makes something else of the samples, and for a label that a sparse field
  // has all around; with ErrorCode::input where a sample is no label or memory runs out; with ErrorCode::cancelled.
  [[nodiscard]] static Result<LabelVoxels> find(const field::ScalarField& field, const ExtractOptions& options,
                                                const LabelChoice& choice, const Context& context);

  // Those that were asked for, in their order, found or not; all of them in rising order.
  [[nodiscard]] const std::vector<std::int64_t>& labels() const;

  // Sentences about the samples that a user should know.
  [[nodiscard]] const std::vector<std::string>& notes() const;

  // The surface of one of them; empty where the label was not found. `field` is the one that was looked at, and
  // `options` are the same but for what a mesh is like. By surface nets the borders of two labels are the same
  // triangles in both meshes, turned over. Fails as Extractor::extract() does.
  [[nodiscard]] Result<Extraction> extract(const field::ScalarField& field, std::int64_t label,
                                           const ExtractOptions& options, const Context& context) const;

 private:
  struct Found;
  explicit LabelVoxels(std::shared_ptr<const Found> found) : found_(std::move(found)) {}

  std::shared_ptr<const Found> found_;
};

}  // namespace isoextract::extract
