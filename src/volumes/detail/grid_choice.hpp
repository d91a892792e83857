// Which of a file's grids is meant.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "base/error.hpp"
#include "volumes/volume_format.hpp"

namespace isoextract::volumes {

// Sets GridInfo::index_of_name and name_repeats from the names.
void number_repeated_names(std::span<GridInfo> grids);

// NAME, or NAME[k] where names repeat.
[[nodiscard]] std::string grid_label(const GridInfo& grid);

// One line a grid: label, type, class, active voxels, box. At most 100 of them.
[[nodiscard]] std::string grid_table(std::span<const GridInfo> grids);

// The index of the wanted grid or, where none is named, of the only scalar one. The hint of a failure lists them.
[[nodiscard]] Result<std::size_t> choose_grid(const std::string& file, std::span<const GridInfo> grids,
                                              const std::optional<std::string>& wanted);

}  // namespace isoextract::volumes
