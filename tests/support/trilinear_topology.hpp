// Computes the topology of the isosurface of a trilinear field by counting, without a case table or a decider.
//
// The field is sampled on a grid of planes that includes the field's own samples, and inside samples count as voxels.
// Some voxels may meet only across an edge or a corner: a square with alternating corners, or a cube whose two opposite
// corners differ from the other six. While there are such places, the planes next to them are moved closer together.
// The result is a well-composed set (Latecki, "3D well-composed pictures", GMIP 59(3), 1997). Its boundary is a surface
// whose vertices, edges and faces are the grid's cubes, squares and edges with both inside and outside corners.
// Between planes the field is trilinear, and the surface in a cell that does not alternate is a disc.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace isoextract::test {

// The sorted Euler numbers of the components of a closed surface: 2 for a sphere, 0 for a torus, ...
using SurfaceTopology = std::vector<int>;

class DisjointSets {
 public:
  std::size_t add() {
    parents_.push_back(parents_.size());
    return parents_.size() - 1;
  }
  std::size_t find(std::size_t a) {
    while (parents_[a] != a) a = parents_[a] = parents_[parents_[a]];
    return a;
  }
  void join(std::size_t a, std::size_t b) { parents_[find(a)] = find(b); }

 private:
  std::vector<std::size_t> parents_;
};

class TrilinearTopology {
 public:
  // Takes size^3 samples, x fastest; inside is value > iso. Boundary samples must be outside.
  TrilinearTopology(const std::vector<float>& samples, int size, double iso)
      : samples_(samples), size_(size), iso_(iso) {}

  // Returns nullopt if planes 2^-20 of a cell apart cannot resolve the surface somewhere.
  std::optional<SurfaceTopology> operator()() {
    std::array<std::vector<double>, 3> planes;
    for (std::vector<double>& axis : planes) {
      for (int i = 0; i < 2 * size_ - 1; ++i) axis.push_back(i / 2.0);
    }
    for (;;) {
      sample(planes);
      std::array<std::vector<bool>, 3> narrow;  // per plane: whether the interval above it is to be refined
      for (int axis = 0; axis < 3; ++axis) narrow[axis].assign(planes[axis].size(), false);
      if (!mark_unclear_places(narrow)) return count();
      for (int axis = 0; axis < 3; ++axis) {
        if (!split(planes[axis], narrow[axis])) return std::nullopt;
      }
    }
  }

 private:
  static bool split(std::vector<double>& planes, const std::vector<bool>& marked) {
    std::vector<double> finer;
    for (std::size_t i = 0; i < planes.size(); ++i) {
      finer.push_back(planes[i]);
      if (!marked[i]) continue;
      if (planes[i + 1] - planes[i] < 0x1p-20) return false;
      finer.push_back((planes[i] + planes[i + 1]) / 2);
    }
    planes = std::move(finer);
    return true;
  }

  void sample(const std::array<std::vector<double>, 3>& planes) {
    for (int axis = 0; axis < 3; ++axis) dims_[axis] = planes[axis].size();
    inside_.assign(dims_[0] * dims_[1] * dims_[2], 0);
    const auto size = static_cast<std::size_t>(size_);
    std::vector<double> row(size);  // the field along x for the row's y and z
    std::size_t n = 0;
    for (const double z : planes[2]) {
      for (const double y : planes[1]) {
        const std::size_t j = std::min(static_cast<std::size_t>(y), size - 2);
        const std::size_t k = std::min(static_cast<std::size_t>(z), size - 2);
        const double v = y - static_cast<double>(j);
        const double w = z - static_cast<double>(k);
        for (std::size_t i = 0; i < size; ++i) {
          const auto at = [&](std::size_t dj, std::size_t dk) {
            return static_cast<double>(samples_[i + size * (j + dj + size * (k + dk))]);
          };
          row[i] = (1 - w) * ((1 - v) * at(0, 0) + v * at(1, 0)) + w * ((1 - v) * at(0, 1) + v * at(1, 1));
        }
        for (const double x : planes[0]) {
          const std::size_t i = std::min(static_cast<std::size_t>(x), size - 2);
          const double u = x - static_cast<double>(i);
          inside_[n++] = (1 - u) * row[i] + u * row[i + 1] > iso_ ? 1 : 0;
        }
      }
    }
  }

  [[nodiscard]] std::size_t step(int axis) const { return axis == 0 ? 1 : axis == 1 ? dims_[0] : dims_[0] * dims_[1]; }

  template <class F>
  void for_each_node(const F& f) const {
    std::array<std::size_t, 3> p{};
    std::size_t n = 0;
    for (p[2] = 0; p[2] < dims_[2]; ++p[2]) {
      for (p[1] = 0; p[1] < dims_[1]; ++p[1]) {
        for (p[0] = 0; p[0] < dims_[0]; ++p[0]) f(p, n++);
      }
    }
  }

  // Returns bits: bit c tells whether corner c of the cube above a node is inside.
  [[nodiscard]] unsigned cube(std::size_t n) const {
    unsigned bits = 0;
    for (unsigned c = 0; c < 8; ++c) {
      bits |= unsigned{inside_[n + (c & 1) * step(0) + (c >> 1 & 1) * step(1) + (c >> 2 & 1) * step(2)]} << c;
    }
    return bits;
  }

  // Returns whether samples meet only across an edge or a corner of the cube.
  static bool is_unclear(unsigned bits) {
    if (bits == 0 || bits == 255) return false;
    for (unsigned corner = 0; corner < 4; ++corner) {
      const unsigned pair = 1U << corner | 1U << (7 - corner);
      if (bits == pair || bits == (255 & ~pair)) return true;
    }
    for (unsigned normal = 1; normal < 8; normal *= 2) {
      const unsigned u = normal == 1 ? 2 : 1;
      const unsigned v = 7 & ~normal & ~u;
      for (const unsigned low : {0U, normal}) {
        const auto in = [&](unsigned c) { return bits >> c & 1; };
        if (in(low) == in(low | u | v) && in(low | u) == in(low | v) && in(low) != in(low | u)) return true;
      }
    }
    return false;
  }

  bool mark_unclear_places(std::array<std::vector<bool>, 3>& narrow) const {
    bool found = false;
    for_each_node([&](const std::array<std::size_t, 3>& p, std::size_t n) {
      if (p[0] + 1 == dims_[0] || p[1] + 1 == dims_[1] || p[2] + 1 == dims_[2] || !is_unclear(cube(n))) return;
      found = true;
      for (int axis = 0; axis < 3; ++axis) narrow[axis][p[axis]] = true;
    });
    return found;
  }

  [[nodiscard]] bool crossed(int axis, std::size_t n) const { return inside_[n] != inside_[n + step(axis)]; }

  [[nodiscard]] SurfaceTopology count() const {
    DisjointSets faces;
    std::array<std::vector<std::size_t>, 3> face_of;  // by axis and lower node of the grid edge
    for (int axis = 0; axis < 3; ++axis) face_of[axis].assign(inside_.size(), 0);
    std::vector<std::size_t> pluses;   // for each vertex of the surface an adjacent face, and every face
    std::vector<std::size_t> minuses;  // for each edge of the surface an adjacent face
    for_each_node([&](const std::array<std::size_t, 3>& p, std::size_t n) {
      for (int axis = 0; axis < 3; ++axis) {
        if (p[axis] + 1 == dims_[axis] || !crossed(axis, n)) continue;
        face_of[axis][n] = faces.add();
        pluses.push_back(face_of[axis][n]);
      }
    });
    for_each_node([&](const std::array<std::size_t, 3>& p, std::size_t n) {
      for (int u = 0; u < 3; ++u) {
        const int v = (u + 1) % 3;
        if (p[u] + 1 == dims_[u] || p[v] + 1 == dims_[v]) continue;
        std::optional<std::size_t> first;
        for (const auto& [axis, node] :
             {std::pair(u, n), std::pair(u, n + step(v)), std::pair(v, n), std::pair(v, n + step(u))}) {
          if (!crossed(axis, node)) continue;
          if (first) faces.join(*first, face_of[axis][node]);
          first = face_of[axis][node];
        }
        if (first) minuses.push_back(*first);
      }
      if (p[0] + 1 < dims_[0] && p[1] + 1 < dims_[1] && p[2] + 1 < dims_[2]) {
        if (const auto face = face_in_cube(n, face_of)) pluses.push_back(*face);
      }
    });
    std::map<std::size_t, int> euler;  // per component
    for (const std::size_t face : pluses) ++euler[faces.find(face)];
    for (const std::size_t face : minuses) --euler[faces.find(face)];
    SurfaceTopology topology;
    for (const auto& [component, number] : euler) topology.push_back(number);
    std::sort(topology.begin(), topology.end());
    return topology;
  }

  // Returns a face of the surface that crosses an edge of the cube above a node; nullopt if there is none.
  [[nodiscard]] std::optional<std::size_t> face_in_cube(std::size_t n,
                                                        const std::array<std::vector<std::size_t>, 3>& face_of) const {
    for (unsigned c = 0; c < 8; ++c) {
      const std::size_t node = n + (c & 1) * step(0) + (c >> 1 & 1) * step(1) + (c >> 2 & 1) * step(2);
      for (int axis = 0; axis < 3; ++axis) {
        if ((c >> axis & 1) == 0 && crossed(axis, node)) return face_of[axis][node];
      }
    }
    return std::nullopt;
  }

  const std::vector<float>& samples_;
  int size_;
  double iso_;
  std::array<std::size_t, 3> dims_{};
  std::vector<std::uint8_t> inside_;
};

}  // namespace isoextract::test
