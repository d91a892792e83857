#include "cli/edit_text.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace isoextract::cli {

namespace {

// "from 30 to 3.29 (89 % less)"
std::string text_of(const convert::RelaxedVolume& volume) {
  const double change = volume.change();
  const double sign = volume.before < 0 ? -1 : 1;  // a cavity's are negative
  return fmt::format("from {:.4g} to {:.4g} ({:.3g} % {})", sign * volume.before, sign * volume.after,
                     100 * std::abs(change), change > 0 ? "more" : "less");
}

bool changed_less(const convert::RelaxedVolume& a, const convert::RelaxedVolume& b) {
  return std::abs(a.change()) < std::abs(b.change());
}

}  // namespace

std::string pieces_summary(const convert::PieceRecord& record, std::string_view word) {
  const edit::PieceCounts& before = record.facts.before;
  const edit::PieceCounts& after = record.facts.after;
  const auto cavities = [](const edit::PieceCounts& counts) { return counts.components - counts.bodies; };
  return fmt::format("pieces at {} {}: {} of {} bodies left, {} of {} cavities, {} of {} triangles; {:.2f} s", word,
                     record.iso, after.bodies, before.bodies, cavities(after), cavities(before), after.triangles,
                     before.triangles, record.facts.time.wall_seconds);
}

std::string smoothing_summary(const convert::SmoothRecord& record, std::string_view word) {
  const edit::SmoothFacts& facts = record.facts;
  std::string text = fmt::format(
      "smoothed at {} {}: {} passes of {}, pass band {}; vertices moved by at most {:.4g} voxels, in the mesh's units "
      "{:.4g}",
      word, record.iso, record.asked.passes, word_of(record.asked.method), record.asked.pass_band, facts.greatest_move,
      facts.greatest_move_world);
  if (facts.border_vertices == 0) {
    const double change = record.volume_change();
    text += fmt::format("; volume {:.4g} % {}", 100 * std::abs(change), change > 0 ? "more" : "less");
  } else {
    text += fmt::format("; {} vertices of open borders stayed", facts.border_vertices);
  }
  if (facts.wall_vertices > 0) text += fmt::format("; {} vertices of caps stayed in their planes", facts.wall_vertices);
  return text + fmt::format("; {:.2f} s", facts.time.wall_seconds);
}

std::optional<std::string> relaxing_note(std::span<const convert::RelaxRecord> records) {
  constexpr double kPercent = 100 * convert::RelaxedVolume::kSmallChange;
  std::vector<convert::RelaxRecord> changed;
  std::uint64_t components = 0;
  std::uint64_t changed_components = 0;
  for (const convert::RelaxRecord& record : records) {
    if (record.whole.is_large()) changed.push_back(record);
    components += record.components;
    changed_components += record.changed_components;
  }
  if (changed_components == 0 && changed.empty()) return std::nullopt;
  std::string text = "relaxing changed the volume of ";
  if (!changed.empty()) {
    const auto worst = std::ranges::max_element(changed, changed_less, &convert::RelaxRecord::whole);
    text += fmt::format("{} {}", worst->surface, text_of(worst->whole));
    if (changed.size() > 1) text += fmt::format(", that of {} others by more than {} %", changed.size() - 1, kPercent);
  }
  // Of a surface that is one component, or of many that all are, there is no more to tell.
  if (changed_components > changed.size()) {
    const auto worst = std::ranges::max_element(records, changed_less, &convert::RelaxRecord::worst_component);
    const convert::RelaxedVolume& volume = worst->worst_component;
    text += fmt::format("{}{} of {} components by more than {} %, most in {}{}, {}", changed.empty() ? "" : ", and of ",
                        changed_components, components, kPercent, volume.before < 0 ? "a cavity of " : "",
                        worst->surface, text_of(volume));
  }
  return text + ": --relax 0 keeps the volumes of the voxels";
}

}  // namespace isoextract::cli
