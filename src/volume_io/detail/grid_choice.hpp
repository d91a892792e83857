// Which of a file's grids is meant, and which of its volumes.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "base/error.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::volume_io {

inline constexpr std::size_t kMaxLabel = 200;  // bytes of a name that are shown

// Sets GridInfo::label from the names: where they look alike, k of NAME[k] counts up in the order of the file, from 0
// on and without those that make the name of another grid.
void label_grids(std::span<GridInfo> grids);

// One line a grid: label, type, class, active voxels, box. At most 100 of them.
[[nodiscard]] std::string grid_table(std::span<const GridInfo> grids);

// The index of the wanted grid, by its label or else by its name, or, where none is named, of the only scalar one. The
// hint of a failure lists them.
[[nodiscard]] Result<std::size_t> choose_grid(const std::string& file, std::span<const GridInfo> grids,
                                              const std::optional<std::string>& wanted);

// The wanted one of `count` volumes, or, where none is asked for, the only one. The hint of a failure says what there
// is to choose from, and `otherwise`, what else could be meant: its text, or a remedy in place of
// Remedy::choose_volume.
[[nodiscard]] Result<std::uint64_t> choose_volume(const std::string& file, std::uint64_t count,
                                                  std::optional<std::int64_t> wanted, const Hint& otherwise = {});

// Likewise one of `count` components, or nothing where the length of all of them is asked for. `names` says what they
// are, in their order, and may be empty.
[[nodiscard]] Result<std::optional<std::uint64_t>> choose_component(const std::string& file, std::uint64_t count,
                                                                    const std::optional<ComponentChoice>& wanted,
                                                                    const std::string& names = {});

}  // namespace isoextract::volume_io
