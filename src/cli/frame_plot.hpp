// The picture of a batch: what its surfaces are like, over the frames, as a gnuplot script.
#pragma once

#include <span>
#include <string>

#include "batch/frame_table.hpp"
#include "cli/error_plot.hpp"

namespace isoextract::cli {

// Triangles, area, volume (of closed surfaces) and components, one below the other; a line an iso value where all
// frames have the same ones, else one for all. A figure that no frame has says why. Dashed lines mark frames that
// failed or were not started.
[[nodiscard]] std::string frame_plot_script(std::span<const batch::FrameRow> rows, PictureFormat format);

}  // namespace isoextract::cli
