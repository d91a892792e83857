#include "mesh_io/write/position_lattice.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "base/number_text.hpp"
#include "base/parallel.hpp"

namespace isoextract::mesh_io {
namespace {

constexpr double kStepsOfVoxel = 32;
constexpr std::uint64_t kShortBits = 16;
constexpr int kFloatDigits = std::numeric_limits<float>::digits;
constexpr int kDoubleDigits = std::numeric_limits<double>::digits;

double greatest(const glm::dvec3& v) { return std::max({v.x, v.y, v.z}); }

// Returns the greatest power of two that is at most `size`.
double power_below(double size) { return std::exp2(std::floor(std::log2(size))); }

// Returns the least power of two s for which size / s is less than 2^digits.
double step_with_digits(double size, int digits) { return size > 0 ? std::ldexp(power_below(size), 1 - digits) : 0; }

glm::dvec3 nearest(const glm::dvec3& position, double step) { return glm::floor(position / step + 0.5); }

double choose_step(const MeshPacking& packing, const mesh::Bounds& box, LatticeUse use, std::uint64_t bits) {
  const double extent = greatest(box.max - box.min);
  const double farthest = greatest(glm::max(glm::abs(box.min), glm::abs(box.max)));
  // One digit less, so that double also holds half steps.
  double least = std::max({step_with_digits(farthest, kDoubleDigits - 1), std::ldexp(1.0, -126)});
  if (use == LatticeUse::float_world) least = std::max(least, step_with_digits(farthest, kFloatDigits));
  if (!packing.position_bits && packing.voxel > 0) least = std::max(least, power_below(packing.voxel / kStepsOfVoxel));
  double step = std::max(least, step_with_digits(extent, static_cast<int>(bits)));
  const double most = std::exp2(static_cast<double>(bits)) - 1;
  while (greatest(nearest(box.max, step) - nearest(box.min, step)) > most) step *= 2;
  return step;
}

// Returns whether the triangle has an area, computed exactly.
bool has_area(const glm::uvec3& a, const glm::uvec3& b, const glm::uvec3& c) {
  const glm::i64vec3 u = glm::i64vec3(b) - glm::i64vec3(a);
  const glm::i64vec3 v = glm::i64vec3(c) - glm::i64vec3(a);
  return glm::i64vec3(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x) != glm::i64vec3(0);
}

bool has_area(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  return glm::cross(glm::dvec3(b) - glm::dvec3(a), glm::dvec3(c) - glm::dvec3(a)) != glm::dvec3(0);
}

struct Moved {
  double axis = 0;
  double squared = 0;
  bool outside = false;

  friend Moved operator+(const Moved& a, const Moved& b) {
    return {std::max(a.axis, b.axis), std::max(a.squared, b.squared), a.outside || b.outside};
  }
};

}  // namespace

PositionLattice choose_lattice(const MeshPacking& packing, const mesh::Bounds& box, LatticeUse use) {
  const std::uint64_t most_bits = use == LatticeUse::short_positions ? kShortBits : kMaxPositionBits;
  PositionLattice lattice;
  lattice.step = choose_step(packing, box, use, std::min(packing.position_bits.value_or(most_bits), most_bits));
  lattice.first = nearest(box.min, lattice.step);
  const glm::dvec3 end = nearest(box.max, lattice.step);
  lattice.last = glm::uvec3(end - lattice.first);
  lattice.bits =
      std::max(1, static_cast<int>(std::bit_width(std::max({lattice.last.x, lattice.last.y, lattice.last.z}))));
  const double farthest = greatest(glm::max(glm::abs(lattice.first), glm::abs(end)));
  const bool is_exact = use != LatticeUse::short_positions && farthest <= std::ldexp(1.0, kFloatDigits);
  if (!is_exact && use != LatticeUse::float_world) lattice.origin = lattice.first * lattice.step;
  return lattice;
}

Result<LatticePositions> round_to_lattice(const mesh::Mesh& mesh, const PositionLattice& lattice) {
  constexpr std::size_t kGrain = 1 << 14;
  LatticePositions result;
  result.numbers = Buffer<glm::uvec3>(mesh.positions.size());
  const glm::dvec3 last(lattice.last);
  const Moved moved = reduce_ranges(
      mesh.positions.size(), kGrain, Moved{},
      [&](std::size_t begin, std::size_t end, Moved sum) {
        for (std::size_t v = begin; v != end; ++v) {
          const glm::dvec3 position = mesh.position(v);
          const glm::dvec3 point = nearest(position, lattice.step);
          const glm::dvec3 number = point - lattice.first;
          const bool inside =
              glm::all(glm::greaterThanEqual(number, glm::dvec3(0))) && glm::all(glm::lessThanEqual(number, last));
          const glm::dvec3 by = glm::abs(point * lattice.step - position);
          sum = sum + Moved{greatest(by), glm::dot(by, by), !inside};
          result.numbers[v] = inside ? glm::uvec3(number) : glm::uvec3(0);
        }
        return sum;
      },
      [](const Moved& a, const Moved& b) { return a + b; });
  if (moved.outside) {
    const glm::dvec3 low = lattice.first * lattice.step;
    const glm::dvec3 high = low + last * lattice.step;
    return fail(ErrorCode::output,
                fmt::format("expected vertices in the quantization box {} .. {}, found vertices outside",
                            point_text(low, 9), point_text(high, 9)));
  }
  result.facts = {lattice.bits, lattice.step, moved.axis, std::sqrt(moved.squared)};
  result.flattened_triangles = reduce_ranges(
      mesh.triangles.size(), kGrain, std::uint64_t{0},
      [&](std::size_t begin, std::size_t end, std::uint64_t count) {
        for (std::size_t t = begin; t != end; ++t) {
          const glm::uvec3& corners = mesh.triangles[t];
          const auto& n = result.numbers;
          const auto& p = mesh.positions;
          const bool flat = !has_area(n[corners.x], n[corners.y], n[corners.z]);
          if (flat && has_area(p[corners.x], p[corners.y], p[corners.z])) ++count;
        }
        return count;
      },
      [](std::uint64_t a, std::uint64_t b) { return a + b; });
  return result;
}

}  // namespace isoextract::mesh_io
