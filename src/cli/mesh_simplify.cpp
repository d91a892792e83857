#include "cli/mesh_simplify.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

namespace isoextract::cli {
namespace {

constexpr double kPatchVoxels = 24;

struct Stretch {
  double least = 1;
  double most = 1;
  // A similarity, to what rounding leaves of it: it stretches all lengths alike.
  [[nodiscard]] bool is_even() const { return most - least <= 1e-9 * most; }
};

// How much the map shortens and lengthens what it maps: its least and greatest singular value. Eigenvalues of the
// symmetric matrix map^T map by the trigonometric formula (O. K. Smith, Eigenvalues of a symmetric 3 x 3 matrix,
// Comm. ACM 4(4), 1961).
Stretch stretch_of(const glm::dmat3& map) {
  const glm::dmat3 a = glm::transpose(map) * map;
  const double mean = (a[0][0] + a[1][1] + a[2][2]) / 3;
  const glm::dmat3 rest = a - mean * glm::dmat3(1.0);
  double squares = 0;
  for (int column = 0; column < 3; ++column) squares += glm::dot(rest[column], rest[column]);
  const double spread = std::sqrt(squares / 6);
  if (!(spread > 0)) return {std::sqrt(mean), std::sqrt(mean)};
  const double half = std::clamp(glm::determinant(rest / spread) / 2, -1.0, 1.0);
  const double angle = std::acos(half) / 3;
  const double most = mean + 2 * spread * std::cos(angle);
  const double least = mean + 2 * spread * std::cos(angle + 2 * std::numbers::pi / 3);
  return {std::sqrt(std::max(least, 0.0)), std::sqrt(most)};
}

}  // namespace

Result<MeshSimplification> simplify_mesh(mesh::Mesh& mesh, double iso, const SimplifyError& error,
                                         const field::Affine& output_from_index, Progress* progress) {
  const Stretch voxel = stretch_of(output_from_index.linear);
  edit::SimplifyOptions options;
  options.max_distance = error.distance;
  options.patch_size = kPatchVoxels * std::cbrt(std::abs(output_from_index.determinant()));
  if (progress != nullptr) progress->begin("simplifying", 0);
  if (!error.in_world_units && voxel.is_even()) {
    options.max_distance = error.distance * voxel.least;
  } else if (!error.in_world_units) {
    options.to_metric = glm::inverse(output_from_index.linear);
    options.patch_size = kPatchVoxels;
  }
  auto done = edit::simplify_within(std::move(mesh), options);
  if (!done) return tl::unexpected(std::move(done.error()));
  edit::SimplifiedMesh& simplified = *done;
  mesh = std::move(simplified.mesh);

  MeshSimplification result;
  result.facts = simplified.facts;
  convert::SimplificationRecord& record = result.record;
  record.iso = iso;
  record.asked = error.distance;
  record.asked_in_voxels = !error.in_world_units;
  const convert::DistanceRange measured{simplified.facts.measured_lower, simplified.facts.measured_upper};
  if (options.to_metric != glm::dmat3(1.0)) {
    record.voxels = measured;
    record.world = {measured.lower * voxel.least, measured.upper * voxel.most};
  } else {
    record.world = measured;
    record.voxels = {measured.lower / voxel.most, measured.upper / voxel.least};
  }
  record.triangles_before = simplified.facts.triangles_before;
  record.triangles_after = simplified.facts.triangles_after;
  record.passes = simplified.facts.passes;
  record.time = simplified.facts.time;
  return result;
}

std::string simplification_summary(const MeshSimplification& simplification) {
  const convert::SimplificationRecord& record = simplification.record;
  const std::string asked =
      fmt::format("{} {}", record.asked, record.asked_in_voxels ? "voxels" : "of the mesh's units");
  if (record.triangles_after == record.triangles_before) {
    return fmt::format("not simplified at iso {}: none of its {} triangles can go within {}; {:.2f} s", record.iso,
                       record.triangles_before, asked, record.time.wall_seconds);
  }
  return fmt::format(
      "simplified at iso {}: {} of {} triangles left ({:.1f} %); asked for at most {}, measured {:.4g} to {:.4g} "
      "voxels, "
      "in the mesh's units {:.4g} to {:.4g}; {:.2f} s",
      record.iso, record.triangles_after, record.triangles_before,
      100.0 * static_cast<double>(record.triangles_after) / static_cast<double>(record.triangles_before), asked,
      record.voxels.lower, record.voxels.upper, record.world.lower, record.world.upper, record.time.wall_seconds);
}

std::string simplification_details(const MeshSimplification& simplification) {
  const edit::Simplification& facts = simplification.facts;
  return fmt::format("{} passes over {} patches; {} patches kept as they were; {:.2f} s of processor time",
                     facts.passes, facts.patches, facts.patches_kept, facts.time.cpu_seconds);
}

}  // namespace isoextract::cli
