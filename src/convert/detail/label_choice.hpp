// Which labels of a label map a job extracts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <unordered_set>
#include <vector>

#include "base/error.hpp"
#include "base/note.hpp"
#include "convert/detail/label_looks.hpp"
#include "convert/iso_values.hpp"
#include "extract/voxels.hpp"

namespace isoextract::convert {

struct LabelCounts {
  std::size_t found = 0;      // labels to choose from: those with voxels, or those of a list
  std::size_t too_small = 0;  // chosen ones with fewer voxels than required

  void add(const LabelCounts& more) {
    found += more.found;
    too_small += more.too_small;
  }
};

struct ChosenLabels {
  std::vector<std::int64_t> labels;            // in the order of a list, rising for a set (IsoChoice::is_label_set())
  std::unordered_set<std::int64_t> too_small;  // labels with fewer voxels than required, without a mesh
  LabelCounts counts;
  Notes notes;

  // Returns the surfaces without those of labels that are too small.
  [[nodiscard]] std::vector<ResolvedIso> large_enough(std::vector<ResolvedIso> surfaces) const {
    std::erase_if(surfaces,
                  [&](const ResolvedIso& iso) { return iso.id.is_label() && too_small.contains(iso.id.label()); });
    return surfaces;
  }
};

// Chooses among the labels of `found`, the result of a search for the labels in `asked`. Labels with fewer than `least`
// voxels are too small. Listed labels without any voxel do not count as too small, so that their missing surface is
// reported. `source` starts the notes. Fails with ErrorCode::no_surface if a number or name of a selection matches no
// label with samples, unless `empty` allows it. Ranges and patterns without a label only get notes.
[[nodiscard]] Result<ChosenLabels> choose_labels(std::span<const ResolvedIso> asked, const extract::LabelVoxels& found,
                                                 const LabelAppearance& looks, std::uint64_t least, EmptyPolicy empty,
                                                 const std::string& source);

// Checks outputs that write the bodies of the label with a given name to a file each. Fails with ErrorCode::usage if
// several labels have this name: the files of the second would replace those of the first.
[[nodiscard]] Result<void> check_piece_names(const ConversionJob& job, const ChosenLabels& chosen,
                                             const LabelAppearance& looks, const std::string& source);

// Surfaces that are made at the same time.
struct LabelGroup {
  std::size_t size = 0;   // at least 1, if surfaces are left
  bool is_small = false;  // the surfaces take little memory, so the previous group may still be in memory
};

// Returns the next group: one surface, or up to 256 surfaces of small labels. On one thread, each surface is a group
// that is not small.
[[nodiscard]] LabelGroup next_group(std::span<const ResolvedIso> next, const extract::LabelVoxels& found);

}  // namespace isoextract::convert
