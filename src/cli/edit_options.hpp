// The options that change fields before extraction and surfaces after it.
#pragma once

#include <string_view>

#include <CLI/CLI.hpp>

#include "base/error.hpp"
#include "cli/option_group.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

void declare_edits(CLI::App& app, EditFlags& flags);
// Of every command that extracts.
void declare_blur(const Group& group, SurfaceFlags& flags);

[[nodiscard]] Result<convert::LeastPiece> parse_least_piece(std::string_view text);  // 100, area:40, volume:5world
[[nodiscard]] Result<convert::SmoothChoice> parse_smoothing(std::string_view text);  // 20, 20:sinc, 20:taubin:0.05
[[nodiscard]] Result<convert::BlurStep> parse_blur(std::string_view text);           // 2, 2voxel, 0.5world, median:1

}  // namespace isoextract::cli
