// Estimates the memory of label surfaces before LabelVoxels looks for them.
#pragma once

#include <cstdint>

#include "extract/voxels.hpp"

namespace isoextract::extract {

struct LabelMapSize {
  std::uint64_t finding_bytes = 0;  // peak of LabelVoxels::find() besides the samples
  std::uint64_t kept_bytes = 0;     // of the LabelVoxels that it returns
  std::uint64_t faces = 0;          // of voxels, between the chosen labels and others; counts once for each chosen side
  std::uint64_t largest_faces = 0;  // of the chosen label with the most faces
  std::uint64_t faces_at_once = 0;  // of the surfaces that are in memory at a time, if small labels are made together
};

// Estimates sizes for the arguments of LabelVoxels::find(). Counts the labels of each chunk of 64x8x8 samples if there
// are at most 8,192 chunks, else of about 8,192 of them, in whole rows of chunks along x; the rest is taken to be alike.
// Counts samples that are no labels as background. Fails as LabelVoxels::find() does for the region, with
// ErrorCode::out_of_memory or cancelled.
[[nodiscard]] Result<LabelMapSize> estimate_label_map(const field::ScalarField& field, const ExtractOptions& options,
                                                      const LabelChoice& choice, const Context& context);

// Small labels are made at the same time: as many as have kSmallLabelChunks chunks, at most kSmallLabels, while the
// surfaces of as many before them are still in memory.
inline constexpr std::uint64_t kSmallLabelChunks = 2048;  // their faces take at most some ten MiB
inline constexpr std::size_t kSmallLabels = 256;

// Returns the bytes that surfaces with so many faces take while they are made.
[[nodiscard]] std::uint64_t label_surface_bytes(std::uint64_t faces);

}  // namespace isoextract::extract
