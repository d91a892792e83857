#include "accuracy/detail/same_triangles.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <tuple>

#include "base/hash.hpp"
#include "base/parallel.hpp"
#include "mesh/buckets.hpp"

namespace isoextract::accuracy {
namespace {

using Corners = std::array<glm::dvec3, 3>;

// Sorts the corners, so that equal triangles give equal arrays.
Corners corners_of(const mesh::Mesh& mesh, std::size_t triangle, const glm::dvec3& shift) {
  Corners corners;
  // The second sum turns -0 into 0.
  for (int c = 0; c < 3; ++c) {
    corners[static_cast<std::size_t>(c)] =
        glm::dvec3(mesh.positions[mesh.triangles[triangle][c]]) + shift + glm::dvec3(0.0);
  }
  std::ranges::sort(corners, {}, [](const glm::dvec3& p) { return std::tuple(p.x, p.y, p.z); });
  return corners;
}

std::uint64_t hash_of(const Corners& corners) {
  std::array<std::uint64_t, 3> parts{};
  for (std::size_t c = 0; c < corners.size(); ++c) {
    parts[c] = hash_coordinates(std::bit_cast<std::uint64_t>(corners[c].x), std::bit_cast<std::uint64_t>(corners[c].y),
                                std::bit_cast<std::uint64_t>(corners[c].z));
  }
  return hash_coordinates(parts[0], parts[1], parts[2]);
}

struct Known {
  std::uint64_t hash;
  std::uint32_t triangle;

  friend bool operator<(const Known& x, const Known& y) {
    return std::tie(x.hash, x.triangle) < std::tie(y.hash, y.triangle);
  }
};

std::size_t bucket_count(const mesh::Mesh& mesh) { return mesh.triangles.size() / 4 + 1; }

}  // namespace

std::vector<char> mark_common_triangles(const mesh::Mesh& a, const mesh::Mesh& b, const glm::dvec3& shift) {
  const std::size_t count = bucket_count(b);
  const mesh::Buckets<Known> known(b.triangles.size(), count, [&](std::size_t t, const auto& put) {
    const std::uint64_t hash = hash_of(corners_of(b, t, glm::dvec3(0.0)));
    put(hash % count, Known{hash, static_cast<std::uint32_t>(t)});
  });
  std::vector<char> in_both(a.triangles.size(), 0);
  for_each_index(in_both.size(), [&](std::size_t t) {
    const Corners corners = corners_of(a, t, shift);
    const std::uint64_t hash = hash_of(corners);
    const auto all = known.at(hash % count);
    auto other = std::ranges::lower_bound(all, hash, {}, &Known::hash);
    for (; other != all.end() && other->hash == hash && in_both[t] == 0; ++other) {
      in_both[t] = corners_of(b, other->triangle, glm::dvec3(0.0)) == corners ? 1 : 0;
    }
  });
  return in_both;
}

std::uint64_t common_triangles_bytes(const mesh::Mesh& a, const mesh::Mesh& b) {
  return mesh::Buckets<Known>::bytes(b.triangles.size(), bucket_count(b)) + a.triangles.size();
}

}  // namespace isoextract::accuracy
