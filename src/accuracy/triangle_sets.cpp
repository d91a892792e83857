#include "accuracy/triangle_sets.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "base/number_text.hpp"
#include "base/reduction.hpp"
#include "mesh/buckets.hpp"

namespace isoextract::accuracy {
namespace {

std::tuple<std::uint32_t, std::uint32_t, std::uint32_t> ordered(const glm::uvec3& t) { return {t.x, t.y, t.z}; }

// Returns the names of a triangle, starting with the rotation that sorts first.
std::optional<glm::uvec3> named(const LabeledVertices& mesh, std::size_t triangle) {
  glm::uvec3 names;
  for (int corner = 0; corner < 3; ++corner) {
    const std::uint32_t vertex = mesh.mesh.triangles[triangle][corner];
    if (vertex >= mesh.names.size() || mesh.names[vertex] == kNoName) return std::nullopt;
    names[corner] = mesh.names[vertex];
  }
  const std::array rotations{names, glm::uvec3(names.y, names.z, names.x), glm::uvec3(names.z, names.x, names.y)};
  return *std::ranges::min_element(rotations, {}, ordered);
}

// The other two names of a triangle; its bucket is the first name.
struct Rest {
  glm::uvec2 names;
  std::uint64_t triangle;

  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> key() const { return {names.x, names.y}; }
  friend bool operator<(const Rest& a, const Rest& b) {
    return std::tuple(a.key(), a.triangle) < std::tuple(b.key(), b.triangle);
  }
};

mesh::Buckets<Rest> by_first_name(const LabeledVertices& mesh, std::uint64_t names) {
  return {mesh.mesh.triangles.size(), names, [&](std::size_t t, const auto& put) {
            if (const auto corners = named(mesh, t)) put(corners->x, Rest{{corners->y, corners->z}, t});
          }};
}

struct Sums {
  std::array<std::uint64_t, 2> only{};
  std::array<std::optional<std::uint64_t>, 2> example{};  // the first such triangle

  void add(std::size_t side, std::uint64_t triangle) {
    ++only[side];
    example[side] = std::min(example[side].value_or(triangle), triangle);
  }
  void merge(const Sums& other) {
    for (std::size_t side = 0; side < 2; ++side) {
      only[side] += other.only[side];
      if (!example[side] || (other.example[side] && *other.example[side] < *example[side])) {
        example[side] = other.example[side];
      }
    }
  }
};

void add_difference(std::span<const Rest> a, std::span<const Rest> b, Sums& sums) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() || j < b.size()) {
    if (j == b.size() || (i < a.size() && a[i].key() < b[j].key())) {
      sums.add(0, a[i++].triangle);
    } else if (i == a.size() || b[j].key() < a[i].key()) {
      sums.add(1, b[j++].triangle);
    } else {
      ++i;
      ++j;
    }
  }
}

// Nonexistent corners become NaN.
std::array<glm::dvec3, 3> corners_of(const mesh::Mesh& mesh, std::uint64_t triangle) {
  std::array<glm::dvec3, 3> corners;
  for (int c = 0; c < 3; ++c) {
    const std::uint32_t vertex = mesh.triangles[triangle][c];
    corners[static_cast<std::size_t>(c)] =
        vertex < mesh.positions.size() ? mesh.position(vertex) : glm::dvec3(std::numeric_limits<double>::quiet_NaN());
  }
  return corners;
}

}  // namespace

TriangleDifference compare_triangle_sets(const LabeledVertices& a, const LabeledVertices& b, std::uint64_t names) {
  const std::array<const LabeledVertices*, 2> sides{&a, &b};
  const std::array buckets{by_first_name(a, names), by_first_name(b, names)};
  Sums sums = reduce_in_order(names, Sums{}, nullptr, [&](const PointRange& range, Sums& part) {
    for (std::size_t name = range.begin(); name != range.end(); ++name) {
      add_difference(buckets[0].at(name), buckets[1].at(name), part);
    }
  });
  TriangleDifference result;
  for (std::size_t side = 0; side < 2; ++side) {
    const LabeledVertices& named_mesh = *sides[side];
    const mesh::Mesh& mesh = named_mesh.mesh;
    result.total[side] = mesh.triangles.size();
    if (buckets[side].total() < mesh.triangles.size()) {
      sums.merge(reduce_in_order(mesh.triangles.size(), Sums{}, nullptr, [&](const PointRange& range, Sums& part) {
        for (std::size_t t = range.begin(); t != range.end(); ++t) {
          if (!named(named_mesh, t)) part.add(side, t);
        }
      }));
    }
    result.only[side] = sums.only[side];
    if (sums.example[side]) result.example[side] = corners_of(mesh, *sums.example[side]);
  }
  return result;
}

void add_difference_sentences(const TriangleDifference& difference, const MeshLabels& names,
                              std::vector<std::string>& sentences) {
  for (std::size_t side = 0; side < 2; ++side) {
    const auto& example = difference.example[side];
    if (!example) continue;
    sentences.push_back(fmt::format("{} of {} triangles are in {} only, one of them {}, {}, {}", difference.only[side],
                                    difference.total[side], names[side], point_text((*example)[0], 9),
                                    point_text((*example)[1], 9), point_text((*example)[2], 9)));
  }
}

std::uint64_t triangle_comparison_bytes(std::uint64_t triangles, std::uint64_t names) {
  return mesh::Buckets<Rest>::bytes(triangles, 2 * names);
}

}  // namespace isoextract::accuracy
