#include "convert/detail/skipped_surfaces.hpp"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace isoextract::convert {
namespace {

std::string preposition(const SurfaceId& id) { return id.is_file_mesh() ? " in " : id.is_iso() ? " at iso " : " at "; }

}  // namespace

SkippedSurfaces skipped_surfaces(const std::string& label, std::span<const ResolvedIso> asked,
                                 std::span<const SurfaceId> written, std::span<const LostSurface> lost) {
  SkippedSurfaces skipped{label, {}};
  const std::set<SurfaceId> made(written.begin(), written.end());
  std::map<SurfaceId, std::string> why;  // the first reason
  for (const LostSurface& surface : lost) why.try_emplace(surface.id, surface.why);
  for (const ResolvedIso& iso : asked) {
    if (made.contains(iso.id)) continue;
    const auto found = why.find(iso.id);
    std::string& surfaces = skipped.reasons[found == why.end() ? "no surface" : found->second];
    if (!iso.id.is_only_surface()) surfaces += (surfaces.empty() ? preposition(iso.id) : ", ") + text_of(iso);
  }
  return skipped;
}

std::string note_of(const SkippedSurfaces& skipped, const std::string& consequence) {
  std::vector<std::string> reasons;
  for (const auto& [why, surfaces] : skipped.reasons) reasons.push_back(why + surfaces);
  return fmt::format("{}: {}; {}", skipped.label, fmt::join(reasons, "; "), consequence);
}

Notes repeated_notes(const std::string& label, std::span<const ResolvedIso> asked, const std::string& path) {
  Notes notes;
  if (std::ranges::all_of(asked, [](const ResolvedIso& iso) { return iso.asked.is_label(); })) return notes;
  for (std::size_t i = 1; i < asked.size(); ++i) {
    const auto before = asked.first(i);
    const auto same = std::ranges::find_if(before, [&](const auto& iso) { return repeats_value(iso, asked[i]); });
    if (same == before.end()) continue;
    notes.push_back({NoteId::repeated_iso,
                     fmt::format("{}: iso {} and {} are the same value, {}: {} has one surface for both", label,
                                 text_of(same->asked), text_of(asked[i].asked), asked[i].id.text(), path)});
  }
  return notes;
}

}  // namespace isoextract::convert
