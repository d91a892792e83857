#include "cli/edit_text.hpp"

#include <cmath>

#include <fmt/format.h>

namespace isoextract::cli {

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

}  // namespace isoextract::cli
