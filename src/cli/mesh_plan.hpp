// Plans conversions whose input is a mesh file.
#pragma once

#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "batch/find_frames.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

// Makes the meshes of an input that is a mesh file the surfaces to convert. For glTF without --up, sets the up axis y,
// which glTF prescribes; then also sets --up-out z for other output formats, unless --up-out is given. Does nothing for
// other inputs, with --heightfield or --input-format, and for raw samples from standard input.
//
// Fails with ErrorCode::usage if an option needs a field, particles or voxels; the message names the option and says
// why.
[[nodiscard]] Result<void> take_mesh(ConvertFlags& flags, const std::string& input, const Context& context);

// Fails with ErrorCode::usage if take_mesh() found a mesh file and the frames are of glTF and of other formats: their
// up axes differ.
[[nodiscard]] Result<void> check_mesh_frames(const ConvertFlags& flags, const batch::Frames& found);

// Returns whether take_mesh() found a mesh file.
[[nodiscard]] bool reads_mesh(const ConvertFlags& flags);

}  // namespace isoextract::cli
