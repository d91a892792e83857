// Surfaces of voxels: each inside sample is a solid box of one index step around it, and the surface consists of the
// exposed faces of these boxes. Samples beyond dense data or the region count as outside, so the surface is closed
// everywhere. Sparse data continue as their background.
//
// Voxels are connected through faces only. Where two voxels touch along an edge or at a corner only, each fan of faces
// gets its own vertex (detail/corner_fans.hpp). So the mesh is a closed, oriented 2-manifold for any set of voxels,
// except with VoxelFaces::rectangles. Its volume is that of the voxels.
//
// By default, coplanar faces are merged into large rectangles (VoxelFaces). The method follows Kostritskii
// (docs/papers.md), who finds the exposed faces in a hash table of voxels. Here a voxel is one bit of a word of 64
// voxels along x.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "base/note.hpp"
#include "extract/extractor.hpp"

namespace isoextract::extract {

// The labels to extract from a label map.
struct LabelChoice {
  bool all = false;                  // all labels except `background` and the background of a sparse field
  std::vector<std::int64_t> values;  // if not all: the labels, without duplicates
  std::int64_t background = 0;       // no label, unless `values` has it

  friend bool operator==(const LabelChoice&, const LabelChoice&) = default;
};

// A label that samples have.
struct FoundLabel {
  std::int64_t label = 0;
  std::uint64_t voxels = 0;  // in the region
  field::IndexBox bounds;    // of these samples
  std::uint64_t chunks = 0;  // chunks of 64x8x8 voxels that extract() visits; its time depends on their number only
  std::uint64_t shells = 0;  // components of the surface; 0 if unknown, as without relaxed surface nets
};

// The voxels of each label of a label map, found in one pass over the samples. A label is the integer that a sample
// holds, or the entry of field::ScalarField::label_ids that this integer indexes.
class LabelVoxels {
 public:
  // Finds the voxels of the chosen labels in options.region; options.iso must be finite, but has no effect. For surface
  // nets it also finds the smoothed corners that the labels share. It does so for all labels, chosen or not, so that
  // the choice changes no mesh. The object keeps its memory reserved as long as it lives. Floating-point samples are
  // labels if all samples of the region, and the background and all tiles of a sparse field, are whole numbers of at
  // most largest_label() (field/label_value.hpp) in absolute value. With NanPolicy::outside, NaN samples have no label.
  // Fails with ErrorCode::usage if the field scales its samples, and if a chosen label is the background of a sparse
  // field. Fails with ErrorCode::input if a sample is no label, if the transform is singular or not finite, if
  // options.region contains no sample, or if sparse samples lie too far from index 0 (field::kMaxSparseIndex). Fails
  // with ErrorCode::input, too, if surface nets have more corners or faces than 32-bit numbers allow. Fails with
  // ErrorCode::out_of_memory or cancelled.
  [[nodiscard]] static Result<LabelVoxels> find(const field::ScalarField& field, const ExtractOptions& options,
                                                const LabelChoice& choice, const Context& context);

  // Returns the chosen labels in the given order, found or not; for LabelChoice::all, the found labels in rising order.
  [[nodiscard]] const std::vector<std::int64_t>& labels() const;

  // Returns the facts about a label, or null if no sample has it. Returns null for labels that were not chosen; with
  // surface nets, only for LabelChoice::background and the background of a sparse field.
  [[nodiscard]] const FoundLabel* find(std::int64_t label) const;

  // Returns sentences about the samples to show to the user.
  [[nodiscard]] const Notes& notes() const;

  // Returns the surface of one label; an empty mesh if the label was not found. `field` must be the field given to
  // find(). `options` must pass check_method(), which is not called here. Of the options only voxel_faces has an effect
  // here; find() used the others. With surface nets, two labels share the triangles of their common faces, with
  // opposite winding. Fails with ErrorCode::input if float32 or 32-bit indices cannot hold the mesh, with
  // ErrorCode::out_of_memory or cancelled. Throws std::bad_alloc.
  [[nodiscard]] Result<Extraction> extract(const field::ScalarField& field, std::int64_t label,
                                           const ExtractOptions& options, const Context& context) const;

 private:
  struct Found;
  explicit LabelVoxels(std::shared_ptr<const Found> found) : found_(std::move(found)) {}

  std::shared_ptr<const Found> found_;
};

}  // namespace isoextract::extract
