// Plans --blur and the options that edit or check surfaces (EditFlags, --simplify, --triangles, --touching, --require).
#pragma once

#include <string>
#include <string_view>

#include "base/error.hpp"
#include "cli/options.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::cli {

// Sets the blurs and edits of `job`. Fails with ErrorCode::usage for --error with --split-components or --hollow, for
// --hollow with a simplification of labels, for --repair without a mesh file, and for --require normals.
[[nodiscard]] Result<void> plan_edits(const ConvertFlags& flags, convert::ConversionJob& job);

// Fails with ErrorCode::usage if `path` (the value of -o; empty without -o) does not suit --split-components. With
// --split-components, a format for one mesh needs {piece}, and {piece} for several iso values or labels needs {iso},
// {label} or {name} as well. Without --split-components, `path` must not contain {piece}.
[[nodiscard]] Result<void> check_piece_outputs(const ConvertFlags& flags, const std::string& path,
                                               const mesh_io::MeshFormatInfo& format);
}  // namespace isoextract::cli
