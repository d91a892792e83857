#include "convert/stages/mesh_touching.hpp"

#include <algorithm>
#include <cmath>
#include <new>

#include <fmt/format.h>

#include "base/allocation_error.hpp"
#include "base/counted.hpp"
#include "base/parallel.hpp"
#include "base/stopwatch.hpp"
#include "edit/separate_touching.hpp"
#include "mesh/coincident_vertices.hpp"

namespace isoextract::convert {
namespace {

constexpr double kMoveInVoxels = 0.001;

// Returns the topology after welding vertices at equal written positions; nullopt if all positions differ.
Result<std::optional<mesh::Topology>> welded_topology(const mesh::Mesh& mesh, const std::string& what,
                                                      const Context& context) {
  const std::uint64_t vertices = mesh.positions.size();
  const bool rounds = mesh.origin != glm::dvec3(0);
  const auto memory = TRY(
      context.reserve(mesh::CoincidentVertices::bytes(vertices) + (rounds ? vertices * sizeof(glm::vec3) : 0), what));
  mesh::Mesh welded;
  welded.name = mesh.name;
  if (rounds) welded.positions = written_positions(mesh);
  const mesh::CoincidentVertices places((rounds ? welded : mesh).positions.span());
  if (places.repeated() == 0) return std::optional<mesh::Topology>();
  const auto copy = TRY(context.reserve(mesh.triangles.size_bytes() + vertices * sizeof(glm::vec3), what));
  if (!rounds) welded.positions = written_positions(mesh);
  welded.triangles = Buffer<glm::uvec3>(mesh.triangles.size());
  std::transform(mesh.triangles.begin(), mesh.triangles.end(), welded.triangles.begin(),
                 [&](const glm::uvec3& t) { return places.of_triangle(t); });
  return std::optional(TRY(mesh::measure_topology(welded, context)));
}

}  // namespace

Buffer<glm::vec3> written_positions(const mesh::Mesh& mesh) {
  constexpr std::size_t kVerticesAtATime = 1 << 12;
  Buffer<glm::vec3> written(mesh.positions.size());
  for_each_index(
      written.size(), [&](std::size_t v) { written[v] = glm::vec3(mesh.position(v)); }, kVerticesAtATime);
  return written;
}

Result<StageReport> separate_touching(Surface& surface, const StageContext& stage) {
  if (stage.job.edits.touching != Touching::apart) return StageReport();
  const Stopwatch watch;
  const edit::SeparationFigures done = TRY(edit::separate_touching_vertices(
      surface.mesh, kMoveInVoxels, stage.source.output_from_index.linear, stage.context));
  surface.distinct_positions = done.touching == 0 && surface.mesh.origin == glm::dvec3(0);
  const bool has_volume = done.touching > 0 && !stage.facts.may_be_open;
  StageReport report = stage.report_on(StageName::touching, surface);
  report.add_timed(
      {{Key::vertices, surface.vertices()},
       {Key::touching, done.touching},
       {Key::moved, done.moved},
       {Key::greatest_move, done.greatest_move},
       {Key::volume,
        has_volume ? Value(Figures{{Key::before, done.volume_before}, {Key::after, done.volume_after}}) : Value()}},
      watch.elapsed());
  return report;
}

Result<std::optional<mesh::Topology>> topology_as_read(const Surface& surface, const ConversionJob& job,
                                                       const Context& context) {
  const MeshFileOptions* const file = job.writes<MeshFileOptions>();
  const bool readers_weld = file != nullptr && mesh_io::mesh_format_info(file->format).readers_weld;
  if (!readers_weld || surface.distinct_positions) return std::optional<mesh::Topology>();
  const std::string what = surface.mesh.name + ": its vertices as readers weld them";
  try {
    return welded_topology(surface.mesh, what, context);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(what + " need more memory than is available"));
  }
}

std::optional<std::string> note_of_touching(std::span<const StageReport> reports) {
  std::uint64_t touching = 0;
  std::uint64_t moved = 0;
  std::uint64_t surfaces = 0;
  double move = 0;
  double change = 0;  // the greatest relative one
  for (const StageReport& report : reports) {
    if (report.stage != StageName::touching) continue;
    const Figures& figures = report.entries.front();
    const auto here = value_at<std::uint64_t>(figures, {Key::touching}).value_or(0);
    if (here == 0) continue;
    ++surfaces;
    touching += here;
    moved += value_at<std::uint64_t>(figures, {Key::moved}).value_or(0);
    move = std::max(move, value_at<double>(figures, {Key::greatest_move}).value_or(0));
    const double before = value_at<double>(figures, {Key::volume, Key::before}).value_or(0);
    const double after = value_at<double>(figures, {Key::volume, Key::after}).value_or(0);
    if (before != 0) change = std::max(change, std::abs(after / before - 1));
  }
  if (touching == 0) return std::nullopt;
  std::string text = fmt::format(
      "sheets of {} touch at edges or vertices; {} of the {} vertices there moved apart, by at most {:.3g} in the "
      "mesh's units. Programs that weld vertices by position keep the sheets apart at the moved vertices",
      counted(surfaces, "surface"), moved, touching, move);
  if (change > 0) text += fmt::format("; volumes changed by at most {:.2g} %", 100 * change);
  return text;
}

}  // namespace isoextract::convert
