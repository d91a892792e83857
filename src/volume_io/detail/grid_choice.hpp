// Selects one of a file's grids, volumes and components.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::volume_io {

inline constexpr std::size_t kMaxLabel = 200;  // longest part of a name that is shown, in bytes

// Sets GridInfo::label from the names. Names that look alike become NAME[k], with k counting from 0 in file order;
// skips labels that are another grid's name.
void label_grids(std::span<GridInfo> grids);

// Returns the index of the grid with the label `wanted`; if there is none, of all grids with this name, as stored, as
// shown or as a path.
[[nodiscard]] std::vector<std::size_t> grids_called(std::span<const GridInfo> grids, const std::string& wanted);

// Returns the failure for a name that `count` grids of a file have.
[[nodiscard]] tl::unexpected<Error> fail_for_several(const std::string& file, std::size_t count,
                                                     const std::string& wanted, Hint hint);

// Returns a table of at most 100 grids, one per line: label, type, class, active voxels, box.
[[nodiscard]] std::string grid_table(std::span<const GridInfo> grids);

// Returns the index of the wanted grid, matched by label and then by name; without a wish, of the only scalar grid. The
// hint of a failure lists the grids.
[[nodiscard]] Result<std::size_t> choose_grid(const std::string& file, std::span<const GridInfo> grids,
                                              const std::optional<std::string>& wanted);

// Returns the wanted one of `count` volumes; without a wish, the only one. The hint of a failure lists the choices and
// `otherwise`, another interpretation of the file.
[[nodiscard]] Result<std::uint64_t> choose_volume(const std::string& file, std::uint64_t count,
                                                  std::optional<std::int64_t> wanted, const Hint& otherwise = {});

// Does the same for components; returns nothing if the length of all components is wanted. `names` lists the
// components' names in order and may be empty.
[[nodiscard]] Result<std::optional<std::uint64_t>> choose_component(const std::string& file, std::uint64_t count,
                                                                    const std::optional<ComponentChoice>& wanted,
                                                                    const std::string& names = {});

}  // namespace isoextract::volume_io
