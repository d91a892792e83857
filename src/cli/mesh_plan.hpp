// Plans conversions whose input is a mesh file.
#pragma once

#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "batch/find_frames.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

// Selects the meshes of `input` as the surfaces to convert, if `input` is a mesh file. For glTF without --up, sets the
// up axis y, which glTF prescribes; then also sets --up-out z for other mesh formats, unless --up-out is given. Does
// nothing for other inputs, for a PLY file with options of particles, with --heightfield or --input-format, and for raw
// samples from standard input.
//
// Fails with ErrorCode::usage if an option or the output needs a field, particles or voxels; the message says why.
[[nodiscard]] Result<void> take_mesh(ConvertFlags& flags, const std::string& input, const Context& context);

// Fails with ErrorCode::usage if some inputs are meshes and others are not, unless their names have frame numbers. Also
// fails if take_mesh() found a mesh file and the frames are of glTF and of other formats: their up axes differ.
[[nodiscard]] Result<void> check_mesh_frames(const ConvertFlags& flags, const batch::Frames& found,
                                             const Context& context);

// Returns whether take_mesh() found a mesh file.
[[nodiscard]] bool reads_mesh(const ConvertFlags& flags);

}  // namespace isoextract::cli
