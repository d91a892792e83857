#include "mesh/exact_sign.hpp"

#include <array>
#include <cmath>
#include <cstddef>

namespace isoextract::mesh {
namespace {

// Sums of doubles that do not overlap, the smallest first, without zeros: Shewchuk, section 2. `kMost` terms at most.
template <std::size_t kMost>
struct Expansion {
  std::array<double, kMost> terms;
  std::size_t count = 0;

  void append(double term) {
    if (term != 0) terms[count++] = term;
  }
  [[nodiscard]] int sign() const { return count == 0 ? 0 : terms[count - 1] > 0 ? 1 : -1; }
};

struct Rounded {
  double sum;
  double error;
};

// Knuth's sum: exactly a + b.
Rounded exact_sum(double a, double b) {
  const double sum = a + b;
  const double b_part = sum - a;
  const double a_part = sum - b_part;
  return {sum, (a - a_part) + (b - b_part)};
}

Rounded exact_product(double a, double b) {
  const double product = a * b;
  return {product, std::fma(a, b, -product)};
}

Expansion<2> difference(double a, double b) {
  const Rounded r = exact_sum(a, -b);
  Expansion<2> result;
  result.append(r.error);
  result.append(r.sum);
  return result;
}

// FAST-EXPANSION-SUM: the terms of both by size, then their sum from the smallest on.
template <std::size_t kA, std::size_t kB>
Expansion<kA + kB> sum_of(const Expansion<kA>& a, const Expansion<kB>& b) {
  Expansion<kA + kB> result;
  double carry = 0;
  for (std::size_t i = 0, j = 0; i < a.count || j < b.count;) {
    const bool from_a = j == b.count || (i < a.count && std::abs(a.terms[i]) < std::abs(b.terms[j]));
    const Rounded r = exact_sum(carry, from_a ? a.terms[i++] : b.terms[j++]);
    result.append(r.error);
    carry = r.sum;
  }
  result.append(carry);
  return result;
}

// SCALE-EXPANSION.
template <std::size_t kA>
Expansion<2 * kA> scaled(const Expansion<kA>& a, double factor) {
  Expansion<2 * kA> result;
  double carry = 0;
  for (std::size_t i = 0; i < a.count; ++i) {
    const Rounded product = exact_product(a.terms[i], factor);
    const Rounded low = exact_sum(carry, product.error);
    result.append(low.error);
    const Rounded high = exact_sum(product.sum, low.sum);
    result.append(high.error);
    carry = high.sum;
  }
  result.append(carry);
  return result;
}

template <std::size_t kA>
Expansion<4 * kA> product_of(const Expansion<kA>& a, const Expansion<2>& b) {
  const Expansion<2 * kA> low = b.count > 1 ? scaled(a, b.terms[0]) : Expansion<2 * kA>();
  const Expansion<2 * kA> high = b.count > 0 ? scaled(a, b.terms[b.count - 1]) : Expansion<2 * kA>();
  return sum_of(low, high);
}

template <std::size_t kA>
Expansion<kA> negated(Expansion<kA> a) {
  for (std::size_t i = 0; i < a.count; ++i) a.terms[i] = -a.terms[i];
  return a;
}

// a.x * b.y - a.y * b.x
Expansion<16> cross_of(const Expansion<2>& ax, const Expansion<2>& ay, const Expansion<2>& bx, const Expansion<2>& by) {
  return sum_of(product_of(ax, by), negated(product_of(ay, bx)));
}

int exact_side_of_plane(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
  const auto from_d = [&](const glm::dvec3& p, int axis) { return difference(p[axis], d[axis]); };
  const Expansion<2> ax = from_d(a, 0), ay = from_d(a, 1), az = from_d(a, 2);
  const Expansion<2> bx = from_d(b, 0), by = from_d(b, 1), bz = from_d(b, 2);
  const Expansion<2> cx = from_d(c, 0), cy = from_d(c, 1), cz = from_d(c, 2);
  const auto det = sum_of(sum_of(product_of(cross_of(bx, by, cx, cy), az), product_of(cross_of(cx, cy, ax, ay), bz)),
                          product_of(cross_of(ax, ay, bx, by), cz));
  return -det.sign();
}

int exact_turn_of(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return cross_of(difference(a.x, c.x), difference(a.y, c.y), difference(b.x, c.x), difference(b.y, c.y)).sign();
}

constexpr double kHalfUlp = 0x1p-53;
// Shewchuk's o3derrboundA and ccwerrboundA.
constexpr double kPlaneError = (7 + 56 * kHalfUlp) * kHalfUlp;
constexpr double kTurnError = (3 + 16 * kHalfUlp) * kHalfUlp;

}  // namespace

int side_of_plane(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
  const glm::dvec3 ad = a - d;
  const glm::dvec3 bd = b - d;
  const glm::dvec3 cd = c - d;
  const double bxcy = bd.x * cd.y;
  const double bycx = bd.y * cd.x;
  const double cxay = cd.x * ad.y;
  const double cyax = cd.y * ad.x;
  const double axby = ad.x * bd.y;
  const double aybx = ad.y * bd.x;
  const double det = ad.z * (bxcy - bycx) + bd.z * (cxay - cyax) + cd.z * (axby - aybx);
  const double size = (std::abs(bxcy) + std::abs(bycx)) * std::abs(ad.z) +
                      (std::abs(cxay) + std::abs(cyax)) * std::abs(bd.z) +
                      (std::abs(axby) + std::abs(aybx)) * std::abs(cd.z);
  const double error = kPlaneError * size;
  if (det > error) return -1;
  if (-det > error) return 1;
  return size == 0 ? 0 : exact_side_of_plane(a, b, c, d);
}

int turn_of(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  const double left = (a.x - c.x) * (b.y - c.y);
  const double right = (a.y - c.y) * (b.x - c.x);
  const double det = left - right;
  const double size = std::abs(left) + std::abs(right);
  const double error = kTurnError * size;
  if (det > error) return 1;
  if (-det > error) return -1;
  return size == 0 ? 0 : exact_turn_of(a, b, c);
}

bool are_collinear(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  for (int axis = 0; axis < 3; ++axis) {
    if (turn_of(along_axis(a, axis), along_axis(b, axis), along_axis(c, axis)) != 0) return false;
  }
  return true;
}

}  // namespace isoextract::mesh
