// Plans conversions whose input is a mesh file.
#pragma once

#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "batch/find_frames.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

// If the input is a mesh file, makes its meshes the surfaces to convert, and takes the up axis that glTF prescribes
// unless --up is given; other formats are then written with z up. Does nothing for other inputs, and for standard
// input.
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
