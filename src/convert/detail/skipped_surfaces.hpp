// Notes about iso values that have no surface of their own in a file.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "convert/iso_values.hpp"

namespace isoextract::convert {

// A surface of which cuts or the choice of components left nothing.
struct LostSurface {
  SurfaceId id;
  std::string why;
};

// The iso values of one grid at which a file has no surface.
struct SkippedSurfaces {
  std::string label;  // of the grid
  bool are_labels = false;
  std::map<std::string, std::vector<std::string>> reasons;  // the texts of iso values by the reason
};

// Those of `asked` that are not among `written`.
[[nodiscard]] SkippedSurfaces skipped_surfaces(const std::string& label, std::span<const ResolvedIso> asked,
                                               std::span<const SurfaceId> written, std::span<const LostSurface> lost,
                                               bool are_labels);

// `consequence` says what became of the file.
[[nodiscard]] std::string note_of(const SkippedSurfaces& skipped, const std::string& consequence);

// Values that were found may be the same, which nobody could know who asked for them. One note for each of them.
[[nodiscard]] std::vector<std::string> repeated_notes(const std::string& label, std::span<const ResolvedIso> asked,
                                                      const std::string& path);

}  // namespace isoextract::convert
