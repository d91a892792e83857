// Plans --blur and the options that edit surfaces (EditFlags, --simplify, --triangles).
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

// Fails with ErrorCode::usage if `path`, the value of -o or empty, cannot hold the bodies of --split-components: a
// format for one mesh needs {piece}. {piece} with several iso values or labels also needs {iso}, {label} or {name}.
// {piece} needs --split-components.
[[nodiscard]] Result<void> check_piece_outputs(const ConvertFlags& flags, const std::string& path,
                                               const mesh_io::MeshFormatInfo& format);
}  // namespace isoextract::cli
