// What relaxing surface nets did to volumes: thin parts lose most of theirs.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "convert/stage_report.hpp"

namespace isoextract::convert {

// A note that relaxing changed volumes by more than a small share: the surface that lost or gained most, and how many
// others did; nothing where none did. `reports` are those of a conversion.
[[nodiscard]] std::optional<std::string> note_of_relaxing(std::span<const StageReport> reports);

}  // namespace isoextract::convert
