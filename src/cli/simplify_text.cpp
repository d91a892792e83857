#include "cli/simplify_text.hpp"

#include <fmt/format.h>

namespace isoextract::cli {

std::string simplification_summary(const convert::MeshSimplification& simplification) {
  const edit::Simplification& facts = simplification.facts;
  const std::string asked = fmt::format("{} {}", simplification.asked.distance,
                                        simplification.asked.in_world_units ? "of the mesh's units" : "voxels");
  if (facts.triangles_after == facts.triangles_before) {
    return fmt::format("not simplified at iso {}: none of its {} triangles can go within {}; {:.2f} s",
                       simplification.iso, facts.triangles_before, asked, facts.time.wall_seconds);
  }
  return fmt::format(
      "simplified at iso {}: {} of {} triangles left ({:.1f} %); asked for at most {}, measured {:.4g} to {:.4g} "
      "voxels, "
      "in the mesh's units {:.4g} to {:.4g}; {:.2f} s",
      simplification.iso, facts.triangles_after, facts.triangles_before,
      100.0 * static_cast<double>(facts.triangles_after) / static_cast<double>(facts.triangles_before), asked,
      simplification.voxels.lower, simplification.voxels.upper, simplification.world.lower, simplification.world.upper,
      facts.time.wall_seconds);
}

std::string simplification_details(const convert::MeshSimplification& simplification) {
  const edit::Simplification& facts = simplification.facts;
  return fmt::format(
      "{} rounds over {} patches; {} of {} collapses taken back in {} passes; {:.2f} s of processor time", facts.rounds,
      facts.patches, facts.taken_back, facts.collapses, facts.passes, facts.time.cpu_seconds);
}

}  // namespace isoextract::cli
