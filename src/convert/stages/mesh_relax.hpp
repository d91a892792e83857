// Changes of volume by relaxing surface nets; thin parts lose most of their volume.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "base/note.hpp"
#include "convert/stage_report.hpp"

namespace isoextract::convert {

// Returns a note if relaxing changed a volume by more than kSmallShare: the surface that changed most, and how many
// others did. Returns nullopt if none did. `reports` are those of one conversion.
[[nodiscard]] std::optional<std::string> note_of_relaxing(std::span<const StageReport> reports);

}  // namespace isoextract::convert
