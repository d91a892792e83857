// Makes the plot of a batch, properties of its surfaces over the frames, as a gnuplot script.
#pragma once

#include <span>
#include <string>

#include "batch/frame_table.hpp"
#include "cli/error_plot.hpp"

namespace isoextract::cli {

// Returns a script with four plots below each other: triangles, area, volume (of closed surfaces) and components. Line
// n shows surface n of each frame. The line's title is the surface's grid and iso value if all frames agree, else
// "surface n"; the key lists at most 20 titles. A plot without data shows the reason. Dashed lines mark frames that
// failed, were cancelled or not started.
[[nodiscard]] std::string frame_plot_script(std::span<const batch::FrameRow> rows, PictureFormat format);

}  // namespace isoextract::cli
