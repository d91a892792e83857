// Decides which grids of a VDB file the OpenVDB plug-in reads: bool, mask and int64 grids, vector grids by component or
// length, and grids in a frustum.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"
#include "volume_io/vdb/vdb_header.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::volume_io {

// Marks the grids that the plug-in reads; only this function decides which. `is_missing`: the plug-in is missing.
void mark_plugin_grids(const VdbHeader& header, std::span<GridInfo> grids, bool is_missing);

struct PluginGrid {
  std::optional<std::string> grid;  // name of the grid for the plug-in; empty if it is the only one
  std::string reason;               // "'velocity' holds vec3s"
};

// Returns the grid that the plug-in must read; nothing if the built-in reader reads the selected grid or if no grid
// fits. Throws InvalidVdb if the grid does not end within its range of the file, as OpenVDB does not validate its
// input.
[[nodiscard]] std::optional<PluginGrid> choose_plugin_grid(VdbCursor& cursor, const VdbHeader& header,
                                                           std::span<const GridInfo> grids, const ReadOptions& options);

// Reads the grid; shifts components of staggered grids to their positions. Fails with ErrorCode::unavailable if the
// plug-in is missing; the message says why it is needed.
[[nodiscard]] Result<field::ScalarField> read_by_plugin(const VolumeFormat& plugin, const std::string& input,
                                                        const PluginGrid& wanted, const VdbHeader& header,
                                                        std::span<const GridInfo> grids, const ReadOptions& options,
                                                        const Context& context);

}  // namespace isoextract::volume_io
