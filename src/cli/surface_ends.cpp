#include "cli/surface_ends.hpp"

#include <algorithm>
#include <set>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace isoextract::cli {

void SurfaceEnds::extracted(const convert::ExtractedSurface& surface) {
  const std::uint64_t hole_cells = surface.stats.hole_cells;
  ends_[surface.iso] = {surface.stats.meets_border && !job_.surface.cap, false, hole_cells > 0, hole_cells};
}

void SurfaceEnds::clipped(double iso, const edit::ClipFacts& facts) {
  if (job_.surface.cap) return;
  ends_[iso].cut = facts.triangles_cut > 0;
  ends_[iso].counted = true;
}

std::string SurfaceEnds::text_of(const convert::WrittenOutput& output) const {
  if (output.triangles == 0) return "empty";
  std::vector<double> at_border;
  bool at_clip = false;
  bool closed = output.open_edges.value_or(0) == 0;
  std::uint64_t hole_cells = 0;
  const std::set<double> isos(output.isos.begin(), output.isos.end());
  for (const double iso : isos) {
    const auto found = ends_.find(iso);
    if (found == ends_.end()) continue;
    const End& end = found->second;
    if (!end.counted && end.at_border) closed = false;
    const bool cut_at_clip = end.cut && !job_.source.clip.empty();
    if (end.at_border || (end.cut && !cut_at_clip)) at_border.push_back(iso);
    at_clip = at_clip || cut_at_clip;
    hole_cells += end.hole_cells;
  }
  std::string text = closed ? "closed" : "open";
  if (!closed && !at_border.empty()) {
    text += fmt::format(" at the border of the {}", job_.source.roi ? "--roi" : "data");
    if (at_border.size() < isos.size()) text += fmt::format(" at iso {}", fmt::join(at_border, ", "));
  }
  if (!closed && at_clip) text += at_border.empty() ? " where --clip cut it" : " and where --clip cut it";
  if (!closed && (at_clip || !at_border.empty())) text += " (--cap closes it)";
  if (hole_cells > 0) text += fmt::format("; without {} cells around samples that are not numbers", hole_cells);
  const bool rectangles = job_.surface.voxel_faces == extract::VoxelFaces::rectangles;
  return closed && rectangles ? text + ", but not edge by edge (--t-junctions)" : text;
}

}  // namespace isoextract::cli
