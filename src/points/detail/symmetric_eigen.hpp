// Eigenvalues and eigenvectors of symmetric 3 x 3 matrices.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/glm.hpp>

namespace isoextract::points {

struct SymmetricEigen {
  glm::dvec3 values{0.0};   // in descending order
  glm::dmat3 vectors{1.0};  // column n belongs to value n; orthonormal
};

// Uses cyclic Jacobi rotations (Golub and Van Loan: Matrix computations, section 8.5.3), which keep small eigenvalues
// accurate and need no special case for equal ones. Reads only the upper triangle of `a`; its entries must be finite.
[[nodiscard]] inline SymmetricEigen symmetric_eigen(glm::dmat3 a) {
  constexpr int kSweeps = 16;  // four or five usually suffice
  SymmetricEigen eigen;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    const double off = std::abs(a[1][0]) + std::abs(a[2][0]) + std::abs(a[2][1]);
    const double diagonal = std::abs(a[0][0]) + std::abs(a[1][1]) + std::abs(a[2][2]);
    if (off <= 1e-18 * diagonal || off == 0) break;
    for (const auto& [p, q] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)}) {
      const double apq = a[q][p];
      if (apq == 0) continue;
      // The smaller of the two rotation angles that make the entry 0.
      const double theta = (a[q][q] - a[p][p]) / (2 * apq);
      const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1));
      const double c = 1 / std::sqrt(t * t + 1);
      const double s = t * c;
      const int r = 3 - p - q;
      a[p][p] -= t * apq;
      a[q][q] += t * apq;
      a[q][p] = 0;
      // The other two off-diagonal entries, in the upper triangle.
      double& arp = a[std::max(r, p)][std::min(r, p)];
      double& arq = a[std::max(r, q)][std::min(r, q)];
      const double old = arp;
      arp = c * old - s * arq;
      arq = s * old + c * arq;
      const glm::dvec3 vp = eigen.vectors[p];
      eigen.vectors[p] = c * vp - s * eigen.vectors[q];
      eigen.vectors[q] = s * vp + c * eigen.vectors[q];
    }
  }
  eigen.values = {a[0][0], a[1][1], a[2][2]};
  const auto order = [&](int m, int n) {
    if (eigen.values[m] >= eigen.values[n]) return;
    std::swap(eigen.values[m], eigen.values[n]);
    std::swap(eigen.vectors[m], eigen.vectors[n]);
  };
  order(0, 1);
  order(0, 2);
  order(1, 2);
  return eigen;
}

}  // namespace isoextract::points
