// Plans --masks: finds the files of the masks, and refuses options that do not work with --masks (ErrorCode::usage).
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/note.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

// Returns the files of the masks in natural order: the inputs, or the volumes in a folder that is the only input. A
// note counts the folder's other files. Fails with ErrorCode::usage if an input is stdin or occurs twice, or if one of
// several inputs is a folder. Fails with ErrorCode::input if a folder has no volume or cannot be read.
[[nodiscard]] Result<std::vector<std::string>> find_masks(std::span<const std::string> inputs, Notes& notes);

// Returns the name that output names use for the masks: the name of the first mask's folder, or "masks" for the current
// or its parent folder.
[[nodiscard]] std::string name_of_masks(std::span<const std::string> masks);

// Refuses options that do not work with --masks, and chooses all labels unless --labels is given. Does nothing without
// --masks.
[[nodiscard]] Result<void> take_masks(ConvertFlags& flags);

// Refuses options of the input and of particles that do not work with --masks. Does nothing without --masks.
[[nodiscard]] Result<void> check_mask_input(const InputFlags& input, const ParticleFlags& particles, const Flag& masks);

}  // namespace isoextract::cli
