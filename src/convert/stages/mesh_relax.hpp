// Notes changes of volume by relaxing surface nets. Relaxing keeps volumes where the cells of the vertices allow it.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "base/note.hpp"
#include "convert/stage_report.hpp"

namespace isoextract::convert {

// Returns a note if relaxing changed the volume of a surface or component by more than 0.1 %: names the surface and the
// component that changed most, and counts the others. Returns nullopt if none did. `reports` are those of one
// conversion.
[[nodiscard]] std::optional<std::string> note_of_relaxing(std::span<const StageReport> reports);

}  // namespace isoextract::convert
