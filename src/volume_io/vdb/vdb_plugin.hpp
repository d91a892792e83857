// What of a VDB file is left to the plug-in around OpenVDB: grids of bool, mask and int64, vectors by a component or by
// their length, and grids in a frustum.
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

// Notes in the list of grids which ones are left to the plug-in: the one place that decides it. `is_missing`: the
// plug-in is.
void mark_plugin_grids(const VdbHeader& header, std::span<GridInfo> grids, bool is_missing);

struct PluginGrid {
  std::optional<std::string> grid;  // which one the plug-in is to read; none where it is the only one
  std::string reason;               // "'velocity' holds vec3s"
};

// Nothing where the built-in reader reads what `options` ask for, or where nobody does. Throws VdbDamaged where a grid
// that is left to the plug-in does not end within its place in the file: OpenVDB believes what it reads.
[[nodiscard]] std::optional<PluginGrid> grid_for_plugin(VdbCursor& cursor, const VdbHeader& header,
                                                        std::span<const GridInfo> grids, const ReadOptions& options);

// Reads it: components of staggered grids where they are. Where the plug-in is missing the error is
// ErrorCode::unavailable, and says what it is needed for.
[[nodiscard]] Result<field::ScalarField> read_by_plugin(const VolumeFormat& plugin, const std::string& input,
                                                        const PluginGrid& wanted, const VdbHeader& header,
                                                        std::span<const GridInfo> grids, const ReadOptions& options,
                                                        const Context& context);

}  // namespace isoextract::volume_io
