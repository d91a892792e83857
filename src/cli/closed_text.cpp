#include "cli/closed_text.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/counted.hpp"

namespace isoextract::cli {
namespace {

// Returns the defects of a mesh file besides boundary edges: "not manifold: ...".
std::string mesh_defects_text(const convert::WeldedDefects& defects) {
  std::vector<std::string> found;
  const auto add = [&](std::uint64_t count, std::string_view one, std::string_view many, std::string_view where) {
    if (count > 0) found.push_back(fmt::format("{} {}", counted(count, one, many), where));
  };
  add(defects.nonmanifold_edges, "edge", "edges", "with more than two triangles");
  add(defects.nonmanifold_vertices, "vertex", "vertices", "where sheets touch");
  add(defects.misoriented_edges, "edge", "edges", "between opposite windings");
  return found.empty() ? std::string() : fmt::format("not manifold: {}", fmt::join(found, ", "));
}

// Returns "not manifold: ..." if readers weld sheets that touch, else an empty text.
std::string welded_defects_text(const convert::WeldedDefects& welded, const convert::ConversionJob& job) {
  if (job.source.mesh) return mesh_defects_text(welded);
  if (welded.nonmanifold_edges == 0 && welded.nonmanifold_vertices == 0) return {};
  return fmt::format("not manifold: readers weld touching sheets at {} and {}{}",
                     counted(welded.nonmanifold_edges, "edge"),
                     counted(welded.nonmanifold_vertices, "vertex", "vertices"),
                     job.edits.touching == convert::Touching::keep ? " (--touching apart separates them)" : "");
}

}  // namespace

std::string closed_or_open_text(const convert::WrittenOutput& output, const convert::ConversionJob& job) {
  if (output.triangles == 0) return "empty";
  std::vector<std::string> at_boundary;
  bool at_clip = false;
  bool is_periodic = false;
  const bool rectangles = job.surface.voxel_faces == extract::VoxelFaces::rectangles;
  bool closed = output.open_edges.value_or(0) == 0 && (output.welded.open_edges == 0 || rectangles);
  std::uint64_t hole_cells = 0;
  // Keyed by field and iso value, since the components of a surface can be several meshes.
  std::map<std::pair<std::string, convert::SurfaceId>, convert::OpenBoundary> surfaces;
  for (const convert::WrittenOutput::Part& part : output.surfaces) surfaces[{part.label, part.id}] = part.end;
  const bool of_one_field = std::ranges::all_of(
      output.surfaces, [&](const auto& part) { return part.label == output.surfaces.front().label; });
  for (const auto& [surface, end] : surfaces) {
    if (!end.needs_count && end.at_data_boundary) closed = false;
    const bool cut_at_clip = end.cut && !job.source.clip.empty();
    if (end.at_data_boundary || (end.cut && !cut_at_clip)) {
      at_boundary.push_back(fmt::format("{}{}", of_one_field ? "" : surface.first + " iso ", surface.second.text()));
    }
    at_clip = at_clip || cut_at_clip;
    is_periodic = is_periodic || end.periodic;
    hole_cells += end.hole_cells;
  }
  const std::string defects = welded_defects_text(output.welded, job);
  std::string text = !closed ? "open" : defects.empty() ? "closed" : defects;
  if (!closed && !at_boundary.empty()) {
    const std::string_view box = " at the faces of the periodic box";
    text += job.source.roi ? " at the boundary of --roi" : is_periodic ? box : " at the data boundary";
    if (job.source.roi && is_periodic) text += " or" + std::string(box);
    if (at_boundary.size() < surfaces.size()) {
      text += fmt::format(" {}{}", of_one_field ? "at iso " : "of ", fmt::join(at_boundary, ", "));
    }
  }
  if (!closed && at_clip) text += at_boundary.empty() ? " where --clip cut it" : " and where --clip cut it";
  if (!closed && job.source.mesh && at_boundary.empty() && !at_clip) {
    text += " at " + counted(output.open_edges.value_or(0), "edge");
  }
  const bool is_terrain = job.surface.heights && !at_clip;
  if (!closed && (at_clip || !at_boundary.empty())) text += is_terrain ? " (--base H closes it)" : " (--cap closes it)";
  if (hole_cells > 0) text += fmt::format("; without {} around NaN samples", counted(hole_cells, "cell"));
  if (!closed && !defects.empty()) text += "; " + defects;
  return closed && rectangles ? text + ", except for T-junctions along edges (--t-junctions)" : text;
}

}  // namespace isoextract::cli
