// Texts about pieces, relaxing and smoothing.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "convert/mesh_pieces.hpp"
#include "convert/mesh_relax.hpp"
#include "convert/mesh_smooth.hpp"

namespace isoextract::cli {

// The lines that every run with these stages shows. `word` is what surfaces are told apart by: "iso", or "label".
[[nodiscard]] std::string pieces_summary(const convert::PieceRecord& record, std::string_view word);
[[nodiscard]] std::string smoothing_summary(const convert::SmoothRecord& record, std::string_view word);

// The note that relaxing changed volumes by more than a small share: the surface that lost or gained most, and how many
// others did; nothing where none did.
[[nodiscard]] std::optional<std::string> relaxing_note(std::span<const convert::RelaxRecord> records);

}  // namespace isoextract::cli
