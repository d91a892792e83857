#include "mesh/exact_sign.hpp"

#include <array>
#include <cmath>
#include <cstddef>

namespace isoextract::mesh {
namespace {

// A sum of at most `kMost` nonoverlapping doubles, in ascending order of magnitude, without zeros: Shewchuk, section 2.
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

// Knuth's two-sum: sum + error is exactly a + b.
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

// FAST-EXPANSION-SUM: merges the terms by magnitude and sums them from the smallest up.
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

// Returns a.x * b.y - a.y * b.x.
Expansion<16> cross_of(const Expansion<2>& ax, const Expansion<2>& ay, const Expansion<2>& bx, const Expansion<2>& by) {
  return sum_of(product_of(ax, by), negated(product_of(ay, bx)));
}

struct ExactVector {
  Expansion<2> x, y, z;
};

ExactVector difference(const glm::dvec3& a, const glm::dvec3& b) {
  return {difference(a.x, b.x), difference(a.y, b.y), difference(a.z, b.z)};
}

int exact_determinant_sign(const ExactVector& a, const ExactVector& b, const ExactVector& c) {
  return sum_of(sum_of(product_of(cross_of(b.x, b.y, c.x, c.y), a.z), product_of(cross_of(c.x, c.y, a.x, a.y), b.z)),
                product_of(cross_of(a.x, a.y, b.x, b.y), c.z))
      .sign();
}

int exact_turn_of(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return cross_of(difference(a.x, c.x), difference(a.y, c.y), difference(b.x, c.x), difference(b.y, c.y)).sign();
}

constexpr double kHalfUlp = 0x1p-53;
// Shewchuk's o3derrboundA and ccwerrboundA.
constexpr double kPlaneError = (7 + 56 * kHalfUlp) * kHalfUlp;
constexpr double kTurnError = (3 + 16 * kHalfUlp) * kHalfUlp;

// Returns the sign of the determinant of three rows, each rounded at most once. Calls exact() if rounding leaves the
// sign undecided.
template <class Exact>
int determinant_sign(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const Exact& exact) {
  const double bxcy = b.x * c.y;
  const double bycx = b.y * c.x;
  const double cxay = c.x * a.y;
  const double cyax = c.y * a.x;
  const double axby = a.x * b.y;
  const double aybx = a.y * b.x;
  const double det = a.z * (bxcy - bycx) + b.z * (cxay - cyax) + c.z * (axby - aybx);
  const double size = (std::abs(bxcy) + std::abs(bycx)) * std::abs(a.z) +
                      (std::abs(cxay) + std::abs(cyax)) * std::abs(b.z) +
                      (std::abs(axby) + std::abs(aybx)) * std::abs(c.z);
  const double error = kPlaneError * size;
  if (det > error) return 1;
  if (-det > error) return -1;
  return size == 0 ? 0 : exact();
}

}  // namespace

int orientation_3d(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
  return determinant_sign(d - a, d - b, d - c,
                          [&] { return exact_determinant_sign(difference(d, a), difference(d, b), difference(d, c)); });
}

int side_of_line(const glm::dvec3& way, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& p) {
  const auto exact_way = [&] { return difference(way, glm::dvec3(0)); };
  const int side = determinant_sign(
      way, a - p, b - p, [&] { return exact_determinant_sign(exact_way(), difference(a, p), difference(b, p)); });
  // A move of p by m adds det(way, m, a - b) to det(way, a - p, b - p).
  for (int axis = 0; side == 0 && axis < 3; ++axis) {
    glm::dvec3 move(0);
    move[axis] = 1;
    const int moved = determinant_sign(way, move, a - b, [&] {
      return exact_determinant_sign(exact_way(), difference(move, glm::dvec3(0)), difference(a, b));
    });
    if (moved != 0) return moved;
  }
  return side;
}

int orientation_2d(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
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
    if (orientation_2d(along_axis(a, axis), along_axis(b, axis), along_axis(c, axis)) != 0) return false;
  }
  return true;
}

}  // namespace isoextract::mesh
