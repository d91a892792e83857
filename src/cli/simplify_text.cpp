#include "cli/simplify_text.hpp"

#include <fmt/format.h>

namespace isoextract::cli {

namespace {

std::string bound_text(const convert::SimplifyBound& bound) {
  return fmt::format("{} {}", bound.distance, bound.in_world_units ? "of the mesh's units" : "voxels");
}

std::string asked_text(const convert::SimplifyChoice& asked) {
  std::string text;
  if (asked.triangles) {
    text = convert::triangle_count_text(*asked.triangles);
    if (!asked.triangles->in_percent) text += " triangles";
  }
  if (asked.triangles && asked.within) text += " and ";
  if (asked.within) text += "at most " + bound_text(*asked.within);
  return text;
}

std::string why_unchanged(const convert::MeshSimplification& simplification) {
  const edit::Simplification& facts = simplification.facts;
  if (facts.triangles_before == 0) return "it has no triangles";
  if (simplification.triangles_asked >= facts.triangles_before && simplification.triangles_asked > 0) {
    return fmt::format("it has {} triangles, and was to keep {}", facts.triangles_before,
                       simplification.triangles_asked);
  }
  if (!simplification.asked.within) {
    return fmt::format("none of its {} triangles can go, or its topology would change", facts.triangles_before);
  }
  return fmt::format("none of its {} triangles can go within {}", facts.triangles_before,
                     bound_text(*simplification.asked.within));
}

}  // namespace

std::string simplification_summary(const convert::MeshSimplification& simplification, std::string_view word) {
  const edit::Simplification& facts = simplification.facts;
  if (facts.triangles_after == facts.triangles_before) {
    return fmt::format("not simplified at {} {}: {}; {:.2f} s", word, simplification.iso, why_unchanged(simplification),
                       facts.time.wall_seconds);
  }
  std::string text = fmt::format(
      "simplified at {} {}: {} of {} triangles left ({:.1f} %); asked for {}, measured {:.4g} to {:.4g} voxels, "
      "in the mesh's units {:.4g} to {:.4g}; {:.2f} s",
      word, simplification.iso, facts.triangles_after, facts.triangles_before,
      100.0 * static_cast<double>(facts.triangles_after) / static_cast<double>(facts.triangles_before),
      asked_text(simplification.asked), simplification.voxels.lower, simplification.voxels.upper,
      simplification.world.lower, simplification.world.upper, facts.time.wall_seconds);
  if (simplification.triangles_asked > 0 && facts.triangles_after > simplification.triangles_asked) {
    text += simplification.asked.within ? "; fewer would be farther away, or change the topology"
                                        : "; fewer would change the topology, or turn triangles over";
  }
  return text;
}

std::string simplification_details(const convert::MeshSimplification& simplification) {
  const edit::Simplification& facts = simplification.facts;
  return fmt::format(
      "{} rounds over {} patches; {} of {} collapses taken back in {} passes; {:.2f} s of processor time", facts.rounds,
      facts.patches, facts.taken_back, facts.collapses, facts.passes, facts.time.cpu_seconds);
}

}  // namespace isoextract::cli
