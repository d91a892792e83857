#include "cli/surface_ends.hpp"

#include <algorithm>
#include <set>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace isoextract::cli {

void SurfaceEnds::extracted(const std::string& label, const convert::ExtractedSurface& surface) {
  const std::uint64_t hole_cells = surface.stats.hole_cells;
  ends_[{label, surface.iso}] = {surface.stats.meets_border && !job_.surface.cap, false, hole_cells > 0, hole_cells};
}

void SurfaceEnds::clipped(const std::string& label, double iso, const edit::ClipFacts& facts) {
  if (job_.surface.cap) return;
  End& end = ends_[{label, iso}];
  end.cut = facts.triangles_cut > 0;
  end.counted = true;
}

std::string SurfaceEnds::text_of(const convert::WrittenOutput& output) const {
  if (output.triangles == 0) return "empty";
  std::vector<std::string> at_border;
  bool at_clip = false;
  bool closed = output.open_edges.value_or(0) == 0;
  std::uint64_t hole_cells = 0;
  std::set<std::pair<std::string, double>> surfaces;
  for (std::size_t i = 0; i < output.isos.size(); ++i) surfaces.emplace(output.labels[i], output.isos[i]);
  const bool of_one_field = std::ranges::all_of(output.labels, [&](const auto& l) { return l == output.labels[0]; });
  for (const auto& surface : surfaces) {
    const auto found = ends_.find(surface);
    if (found == ends_.end()) continue;
    const End& end = found->second;
    if (!end.counted && end.at_border) closed = false;
    const bool cut_at_clip = end.cut && !job_.source.clip.empty();
    if (end.at_border || (end.cut && !cut_at_clip)) {
      at_border.push_back(fmt::format("{}{}", of_one_field ? "" : surface.first + " iso ", surface.second));
    }
    at_clip = at_clip || cut_at_clip;
    hole_cells += end.hole_cells;
  }
  std::string text = closed ? "closed" : "open";
  if (!closed && !at_border.empty()) {
    text += fmt::format(" at the border of the {}", job_.source.roi ? "--roi" : "data");
    if (at_border.size() < surfaces.size()) {
      text += fmt::format(" {}{}", of_one_field ? "at iso " : "of ", fmt::join(at_border, ", "));
    }
  }
  if (!closed && at_clip) text += at_border.empty() ? " where --clip cut it" : " and where --clip cut it";
  if (!closed && (at_clip || !at_border.empty())) text += " (--cap closes it)";
  if (hole_cells > 0) text += fmt::format("; without {} cells around samples that are not numbers", hole_cells);
  const bool rectangles = job_.surface.voxel_faces == extract::VoxelFaces::rectangles;
  return closed && rectangles ? text + ", but not edge by edge (--t-junctions)" : text;
}

}  // namespace isoextract::cli
