#include "convert/mesh_normals.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "base/buffer.hpp"
#include "base/parallel.hpp"
#include "base/stopwatch.hpp"
#include "convert/stages/mesh_facts.hpp"
#include "convert/stages/mesh_touching.hpp"
#include "convert/stages/surface_stages.hpp"
#include "mesh/metrics.hpp"
#include "mesh/shading_normals.hpp"

namespace isoextract::convert {
namespace {

bool has_vertex_normals(const ConversionJob& job) {
  return job.normals == Normals::smooth || job.normals == Normals::area;
}

// Returns the box of samples whose faces the caps lie on, or nullopt without caps.
std::optional<field::IndexBox> capped_box(const field::ScalarField& field, const extract::ExtractOptions& extracted) {
  if (!extracted.cap) return std::nullopt;
  if (!std::holds_alternative<field::DenseSamples>(field.samples)) return extracted.region;
  const field::IndexBox all = field.extents();
  if (!extracted.region) return all;
  return field::IndexBox{glm::max(all.min, extracted.region->min), glm::min(all.max, extracted.region->max)};
}

// Numbers the cap plane that contains a whole triangle: 1 to 6 for the faces of the capped box, 7 and up for the planes
// of capped cuts, 0 for none.
class CapFaces {
 public:
  CapFaces(const mesh::Mesh& mesh, const field::Affine& output_from_index, const std::optional<field::IndexBox>& box,
           std::span<const mesh::HalfSpace> cuts)
      : mesh_(mesh),
        cuts_(cuts),
        index_from_local_(glm::inverse(output_from_index.linear)),
        offset_(index_from_local_ * (mesh.origin - output_from_index.offset)),
        box_(box) {
    // Vertices off the faces are at least twice this tolerance away from each face (extract/edge_geometry.hpp).
    const float farthest = mesh::farthest_coordinate(mesh.positions.span());
    constexpr double kRoundings = 4 * 0x1p-24;
    for (int axis = 0; axis < 3; ++axis) {
      const glm::dvec3 row(index_from_local_[0][axis], index_from_local_[1][axis], index_from_local_[2][axis]);
      tolerance_[axis] = kRoundings * static_cast<double>(farthest) * glm::length(row) + 1e-9;
    }
    cut_tolerance_ = 2 * mesh::on_plane_tolerance(farthest);
  }

  [[nodiscard]] std::uint8_t operator()(const glm::uvec3& triangle) const {
    unsigned on = box_ ? 0x3F : 0;  // one bit for each face
    for (int corner = 0; corner < 3 && on != 0; ++corner) {
      on &= faces_at(offset_ + index_from_local_ * glm::dvec3(mesh_.positions[triangle[corner]]));
    }
    return on == 0 ? cut_of(triangle) : static_cast<std::uint8_t>(1 + std::countr_zero(on));
  }

 private:
  // Number 255 stands for all further planes.
  [[nodiscard]] std::uint8_t cut_of(const glm::uvec3& triangle) const {
    for (std::size_t cut = 0; cut < cuts_.size(); ++cut) {
      bool in = true;
      for (int corner = 0; corner < 3 && in; ++corner) {
        in = std::abs(cuts_[cut].depth(mesh_.position(triangle[corner]))) <= cut_tolerance_;
      }
      if (in) return static_cast<std::uint8_t>(std::min<std::size_t>(7 + cut, 255));
    }
    return 0;
  }

  [[nodiscard]] unsigned faces_at(const glm::dvec3& index) const {
    unsigned faces = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(index[axis] - box_->min[axis]) <= tolerance_[axis]) faces |= 1U << (2 * axis);
      if (std::abs(index[axis] - box_->max[axis]) <= tolerance_[axis]) faces |= 2U << (2 * axis);
    }
    return faces;
  }

  const mesh::Mesh& mesh_;
  std::span<const mesh::HalfSpace> cuts_;
  glm::dmat3 index_from_local_;
  glm::dvec3 offset_;
  std::optional<field::IndexBox> box_;
  glm::dvec3 tolerance_{0.0};  // in voxels
  double cut_tolerance_ = 0;   // in the mesh's coordinates
};

// Fits the normals to the triangles if the job has vertex normals.
Result<StageReport> fit_normals(Surface& surface, const StageContext& stage) {
  const ConversionJob& job = stage.job;
  const Source& source = stage.source;
  const Context& context = stage.context;
  mesh::Mesh& mesh = surface.mesh;
  if (!has_vertex_normals(job) || mesh.triangles.empty()) return StageReport();
  const auto box = capped_box(source.field, source.extract_options(job.surface, surface.id.iso_or_zero()));
  const std::span<const mesh::HalfSpace> cuts =
      job.surface.cap ? std::span<const mesh::HalfSpace>(source.clip) : std::span<const mesh::HalfSpace>();
  const bool has_caps = box || !cuts.empty();
  if (job.normals == Normals::smooth && !job.edits.simplify && !has_caps) return StageReport();
  const Stopwatch watch;
  context.progress().begin("normals", 0);
  mesh::ShadingOptions options;
  options.may_copy = copies_vertices(job);
  if (job.edits.simplify) options.crease_degrees = kCreaseDegrees;
  const std::size_t triangles = has_caps ? mesh.triangles.size() : 0;
  const auto memory = TRY(context.reserve(triangles, source.label + ": normals"));
  Buffer<std::uint8_t> planes(triangles);
  if (has_caps) {
    const CapFaces face_of(mesh, source.output_from_index, box, cuts);
    for_each_index(
        triangles, [&](std::size_t t) { planes[t] = face_of(mesh.triangles[t]); }, 1 << 12);
    options.planes = std::as_const(planes).span();
  }
  const std::uint64_t before = mesh.positions.size();
  const auto copies = TRY(mesh::compute_shading_normals(mesh, options, source.label, context));
  StageReport report = stage.report_on(StageName::normals, surface);
  report.time = watch.elapsed();
  report.did = "normals computed";
  report.work.push_back(
      {WorkTopic::normal_copies, WorkDone::copied, copies, before,
       fmt::format("{} of {} vertices, to give each side of a crease its own normal", copies, before)});
  return report;
}

}  // namespace

bool copies_vertices(const ConversionJob& job) {
  return has_vertex_normals(job) && (job.surface.cap || job.edits.simplify);
}

Result<StageReport> shade_surface(Surface& surface, const StageContext& stage) {
  surface.welded = TRY(topology_as_read(surface, stage.job, stage.context));
  if (stage.source.of_meshes && !surface.welded) {
    surface.welded = TRY(mesh::measure_topology(surface.mesh, stage.context));
  }
  if (stage.facts.recorded) {
    // Measures for reports only: finding components and open edges takes longer than extracting the mesh.
    const Stopwatch watch;
    surface.facts = TRY(mesh_facts(surface, stage.context));
    surface.measuring_time += watch.elapsed();
  }
  if (stage.source.of_meshes) {
    surface.open_edges = surface.welded->open_edges;
  } else if (surface.counts_open_edges) {
    const auto known = surface.facts ? value_at<std::uint64_t>(*surface.facts, {Key::open_edges}) : std::nullopt;
    if (!known) {
      const mesh::Topology topology = TRY(mesh::measure_topology(surface.mesh, stage.context));
      surface.open_edges = topology.open_edges;
    } else {
      surface.open_edges = known;
    }
  }
  return fit_normals(surface, stage);
}

bool may_be_open(const extract::ExtractStats& stats, const extract::ExtractOptions& extracted) {
  if (extract::method_info(extracted.method).traits.always_closed) return false;
  return stats.hole_cells > 0 || (stats.meets_boundary && !extracted.cap);
}

}  // namespace isoextract::convert
