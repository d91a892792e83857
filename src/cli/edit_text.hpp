// How pieces and smoothing are told.
#pragma once

#include <string>
#include <string_view>

#include "convert/mesh_pieces.hpp"
#include "convert/mesh_smooth.hpp"

namespace isoextract::cli {

// The lines that every run with these stages shows. `word` is what surfaces are told apart by: "iso", or "label".
[[nodiscard]] std::string pieces_summary(const convert::PieceRecord& record, std::string_view word);
[[nodiscard]] std::string smoothing_summary(const convert::SmoothRecord& record, std::string_view word);

}  // namespace isoextract::cli
