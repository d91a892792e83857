#include "convert/mesh_simplify.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

#include <fmt/format.h>

namespace isoextract::convert {
namespace {

constexpr double kPatchVoxels = 32;

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

std::uint64_t wanted(const TriangleCount& count, std::uint64_t there) {
  const double whole = count.in_percent ? std::floor(count.amount / 100 * static_cast<double>(there)) : count.amount;
  return std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::min(whole, static_cast<double>(there))));
}

}  // namespace

std::string triangle_count_text(const TriangleCount& count) {
  return fmt::format("{}{}", count.amount, count.in_percent ? "%" : "");
}

std::string simplify_bound_text(const SimplifyBound& bound) {
  return fmt::format("{}{}", bound.distance, bound.in_world_units ? "world" : "voxel");
}

Result<MeshSimplification> simplify_mesh(mesh::Mesh& mesh, double iso, const SimplifyChoice& choice,
                                         const field::Affine& output_from_index, const Context& context) {
  const Stretch voxel = stretch_of(output_from_index.linear);
  edit::SimplifyOptions options;
  options.max_distance = choice.within ? choice.within->distance : std::numeric_limits<double>::infinity();
  options.patch_size = kPatchVoxels * std::cbrt(std::abs(output_from_index.determinant()));
  if (choice.triangles) options.triangles = wanted(*choice.triangles, mesh.triangles.size());
  const bool in_world_units = choice.within && choice.within->in_world_units;
  if (!in_world_units && voxel.is_even()) {
    options.max_distance *= voxel.least;
  } else if (!in_world_units) {
    options.to_metric = glm::inverse(output_from_index.linear);
    options.patch_size = kPatchVoxels;
  }
  auto simplified = edit::simplify_within(std::move(mesh), options, context);
  if (!simplified) return tl::unexpected(std::move(simplified.error()));
  mesh = std::move(simplified->mesh);

  MeshSimplification result;
  result.iso = iso;
  result.asked = choice;
  result.triangles_asked = options.triangles;
  result.facts = simplified->facts;
  const DistanceRange measured{simplified->facts.measured_lower, simplified->facts.measured_upper};
  if (options.to_metric != glm::dmat3(1.0)) {
    result.voxels = measured;
    result.world = {measured.lower * voxel.least, measured.upper * voxel.most};
  } else {
    result.world = measured;
    result.voxels = {measured.lower / voxel.most, measured.upper / voxel.least};
  }
  return result;
}

}  // namespace isoextract::convert
