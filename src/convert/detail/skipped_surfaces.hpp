// Notes about iso values without a surface of their own in a file.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "base/note.hpp"
#include "convert/iso_values.hpp"

namespace isoextract::convert {

// A surface that clipping or the choice of components removed entirely.
struct LostSurface {
  SurfaceId id;
  std::string why;
};

// The surfaces of one grid or mesh file that a file lacks.
struct SkippedSurfaces {
  std::string label;  // of the grid's field
  // The surfaces by reason: " at iso 0.3, 0.4"; empty texts for SurfaceId::is_only_surface().
  std::map<std::string, std::string> reasons;
};

[[nodiscard]] inline bool is_nothing(const SkippedSurfaces& skipped) { return skipped.reasons.empty(); }

// Returns the surfaces of `asked` that are not among `written`, with the reasons that `lost` states.
[[nodiscard]] SkippedSurfaces skipped_surfaces(const std::string& label, std::span<const ResolvedIso> asked,
                                               std::span<const SurfaceId> written, std::span<const LostSurface> lost);

// Returns the note; `consequence` says what happened to the file.
[[nodiscard]] std::string note_of(const SkippedSurfaces& skipped, const std::string& consequence);

// Returns a note for each iso value that equals an earlier one, unless the user gave both as numbers (repeats_value()):
// the user cannot foresee which values found in the field coincide. Labels get no note.
[[nodiscard]] Notes repeated_notes(const std::string& label, std::span<const ResolvedIso> asked,
                                   const std::string& path);

}  // namespace isoextract::convert
