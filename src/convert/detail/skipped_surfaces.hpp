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

// The iso values of one grid at which a file has no surface.
struct SkippedSurfaces {
  std::string label;  // of the grid's field
  bool are_labels = false;
  std::map<std::string, std::vector<std::string>> reasons;  // texts of iso values, by reason
};

[[nodiscard]] inline bool is_nothing(const SkippedSurfaces& skipped) { return skipped.reasons.empty(); }

// Returns the surfaces of `asked` that are not among `written`, with the reasons that `lost` states.
[[nodiscard]] SkippedSurfaces skipped_surfaces(const std::string& label, std::span<const ResolvedIso> asked,
                                               std::span<const SurfaceId> written, std::span<const LostSurface> lost,
                                               bool are_labels);

// Returns the note; `consequence` says what happened to the file.
[[nodiscard]] std::string note_of(const SkippedSurfaces& skipped, const std::string& consequence);

// Returns a note for each iso value that equals an earlier one, unless the user gave both as numbers (repeats_value()):
// the user cannot foresee which values found in the field coincide. Labels get no note.
[[nodiscard]] Notes repeated_notes(const std::string& label, std::span<const ResolvedIso> asked,
                                   const std::string& path);

}  // namespace isoextract::convert
