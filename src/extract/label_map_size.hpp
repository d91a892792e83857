// Estimates the memory of label surfaces before LabelVoxels looks for them.
#pragma once

#include <cstdint>

#include "extract/voxels.hpp"

namespace isoextract::extract {

struct LabelMapSize {
  std::uint64_t voxel_bytes = 0;    // of the voxels of labels, which LabelVoxels::find() finds first
  std::uint64_t finding_bytes = 0;  // peak of the rest of find(), when it needs the samples no more; with voxel_bytes
  std::uint64_t kept_bytes = 0;     // of the LabelVoxels that it returns
  std::uint64_t listing_bytes = 0;  // of the lists of faces of the surfaces that are made at a time
  std::uint64_t group_bytes = 0;    // of the surfaces that are made or written at a time
  std::uint64_t largest_bytes = 0;  // of the largest surface
  std::uint64_t mesh_bytes = 0;     // of all surfaces
  std::uint64_t labels = 0;         // chosen ones
  std::uint64_t faces = 0;          // of voxels, between a chosen label and another one or none
  std::uint64_t sides = 0;          // of these faces, on which a chosen label is: the faces of all surfaces together
  std::uint64_t largest_sides = 0;  // of the label with the most
};

// Estimates sizes for the arguments of LabelVoxels::find(). Counts the labels in up to 8,192 chunks of 64x8x8 samples.
// If there are more chunks, counts evenly spread rows of chunks along x, and assumes that the others have as many.
// Counts samples that are no labels as background. Fails as LabelVoxels::find() does for the region, with
// ErrorCode::out_of_memory or cancelled.
[[nodiscard]] Result<LabelMapSize> estimate_label_map(const field::ScalarField& field, const ExtractOptions& options,
                                                      const LabelChoice& choice, const Context& context);

// Small labels are made at the same time: as many as have kSmallLabelChunks chunks, at most kSmallLabels, while the
// surfaces of as many before them are still in memory.
inline constexpr std::uint64_t kSmallLabelChunks = 2048;  // their faces take at most some ten MiB
inline constexpr std::size_t kSmallLabels = 256;

}  // namespace isoextract::extract
