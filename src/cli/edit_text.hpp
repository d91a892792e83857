// How pieces and smoothing are told.
#pragma once

#include <string>

#include "convert/mesh_pieces.hpp"
#include "convert/mesh_smooth.hpp"

namespace isoextract::cli {

// The lines that every run with these stages shows.
[[nodiscard]] std::string pieces_summary(const convert::PieceRecord& record);
[[nodiscard]] std::string smoothing_summary(const convert::SmoothRecord& record);

}  // namespace isoextract::cli
