#include "accuracy/extraction_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <tuple>

#include <fmt/format.h>

#include "accuracy/float_spacing.hpp"
#include "accuracy/triangle_sets.hpp"
#include "base/reduction.hpp"
#include "mesh/buckets.hpp"

namespace isoextract::accuracy {
namespace {

struct KeyedVertex {
  mesh::EdgeKey key;
  std::uint32_t vertex;

  friend bool operator<(const KeyedVertex& a, const KeyedVertex& b) {
    return std::tie(a.key, a.vertex) < std::tie(b.key, b.vertex);
  }
};

// About this many vertices share a bucket: the vertices of a grid block, which are close together in a mesh as well.
constexpr std::size_t kVerticesABucket = 16;
constexpr int kBlockBits = 2;

mesh::Buckets<KeyedVertex> by_block(const mesh::Mesh& mesh, std::size_t buckets) {
  return {
      mesh.edges.size(), buckets, [&](std::size_t v, const auto& put) {
        const mesh::EdgeKey& key = mesh.edges[v];
        const glm::ivec3 block = key.low >> kBlockBits;
        put(mesh::bucket_of_cell(block.x, block.y, block.z, buckets), KeyedVertex{key, static_cast<std::uint32_t>(v)});
      }};
}

double ulps_apart(const mesh::Mesh& a, std::uint32_t in_a, const mesh::Mesh& b, std::uint32_t in_b) {
  const glm::dvec3 p(a.positions[in_a]);
  const glm::dvec3 q(b.positions[in_b]);
  const glm::dvec3 away = (p - q) + (a.origin - b.origin);
  if (!std::isfinite(away.x) || !std::isfinite(away.y) || !std::isfinite(away.z)) {
    return std::numeric_limits<double>::infinity();
  }
  return max_abs_coordinate(away) / float_spacing(std::max(max_abs_coordinate(p), max_abs_coordinate(q)));
}

double degrees_apart(const glm::vec3& n, const glm::vec3& m) {
  const glm::dvec3 u(n);
  const glm::dvec3 v(m);
  const double angle = std::atan2(glm::length(glm::cross(u, v)), glm::dot(u, v));
  return std::isfinite(angle) ? angle * 180 / std::numbers::pi : std::numeric_limits<double>::infinity();
}

struct Worst {
  double amount = 0;
  std::optional<mesh::EdgeKey> edge;

  void add(double other_amount, const mesh::EdgeKey& other_edge) {
    if (other_amount < amount || other_amount == 0) return;
    if (other_amount == amount && !(other_edge < *edge)) return;
    amount = other_amount;
    edge = other_edge;
  }
};

struct MatchedVertices {
  std::array<std::uint64_t, 2> only{};
  std::array<std::optional<mesh::EdgeKey>, 2> example{};
  Worst position;
  Worst normal;

  void add_only(std::size_t side, std::uint64_t count, const mesh::EdgeKey& edge) {
    if (count == 0) return;
    only[side] += count;
    if (!example[side] || edge < *example[side]) example[side] = edge;
  }
  void merge(const MatchedVertices& other) {
    for (std::size_t side = 0; side < 2; ++side) {
      if (other.example[side]) add_only(side, other.only[side], *other.example[side]);
    }
    if (other.position.edge) position.add(other.position.amount, *other.position.edge);
    if (other.normal.edge) normal.add(other.normal.amount, *other.normal.edge);
  }
};

// Finds the edge keys that both meshes have. Vertices with such a key are named by the first vertex of mesh a with it.
class VertexMatcher {
 public:
  VertexMatcher(const mesh::Mesh& a, const mesh::Mesh& b)
      : a_(a),
        b_(b),
        normals_(!a.normals.empty() && !b.normals.empty()),
        names_a_(a.edges.size()),
        names_b_(b.edges.size()) {}

  MatchedVertices run() {
    const std::size_t buckets = bucket_count(a_, b_);
    const mesh::Buckets<KeyedVertex> of_a = by_block(a_, buckets);
    const mesh::Buckets<KeyedVertex> of_b = by_block(b_, buckets);
    return reduce_in_order(buckets, MatchedVertices{}, nullptr, [&](const PointRange& range, MatchedVertices& sums) {
      for (std::size_t bucket = range.begin(); bucket != range.end(); ++bucket) {
        match(of_a.at(bucket), of_b.at(bucket), sums);
      }
    });
  }

  [[nodiscard]] std::span<const std::uint32_t> names_a() const { return names_a_.span(); }
  [[nodiscard]] std::span<const std::uint32_t> names_b() const { return names_b_.span(); }

  static std::uint64_t bytes(const mesh::Mesh& a, const mesh::Mesh& b) {
    const std::uint64_t vertices = a.edges.size() + b.edges.size();
    return mesh::Buckets<KeyedVertex>::bytes(vertices, 2 * bucket_count(a, b)) + vertices * sizeof(std::uint32_t);
  }

 private:
  using Run = std::span<const KeyedVertex>;

  static std::size_t bucket_count(const mesh::Mesh& a, const mesh::Mesh& b) {
    return std::max(a.edges.size(), b.edges.size()) / kVerticesABucket + 1;
  }

  // Takes the leading vertices with this key off `sorted`.
  static Run take_run(Run& sorted, const mesh::EdgeKey& key) {
    std::size_t size = 0;
    while (size < sorted.size() && sorted[size].key == key) ++size;
    const Run run = sorted.first(size);
    sorted = sorted.subspan(size);
    return run;
  }

  void match(Run a, Run b, MatchedVertices& sums) {
    while (!a.empty() || !b.empty()) {
      const bool from_a = b.empty() || (!a.empty() && a.front().key < b.front().key);
      const mesh::EdgeKey key = from_a ? a.front().key : b.front().key;
      const Run of_a = take_run(a, key);
      const Run of_b = take_run(b, key);
      const std::uint32_t name = of_a.empty() || of_b.empty() ? kNoName : of_a.front().vertex;
      for (const KeyedVertex& v : of_a) names_a_[v.vertex] = name;
      for (const KeyedVertex& v : of_b) names_b_[v.vertex] = name;
      const std::size_t common = std::min(of_a.size(), of_b.size());
      sums.add_only(0, of_a.size() - common, key);
      sums.add_only(1, of_b.size() - common, key);
      for (std::size_t i = 0; i < common; ++i) compare(of_a[i].vertex, of_b[i].vertex, key, sums);
    }
  }

  void compare(std::uint32_t in_a, std::uint32_t in_b, const mesh::EdgeKey& key, MatchedVertices& sums) const {
    sums.position.add(ulps_apart(a_, in_a, b_, in_b), key);
    if (normals_) sums.normal.add(degrees_apart(a_.normals[in_a], b_.normals[in_b]), key);
  }

  const mesh::Mesh& a_;
  const mesh::Mesh& b_;
  bool normals_;
  Buffer<std::uint32_t> names_a_;
  Buffer<std::uint32_t> names_b_;
};

}  // namespace

Result<ExtractionComparison> compare_extractions(const mesh::Mesh& a, const mesh::Mesh& b, const Context& context) {
  for (const mesh::Mesh* mesh : {&a, &b}) {
    if (mesh->edges.size() == mesh->positions.size()) continue;
    return fail(ErrorCode::verification,
                fmt::format("{}: expected an edge key for each of the {} vertices, found {} keys", mesh->name,
                            mesh->positions.size(), mesh->edges.size()));
  }
  const std::uint64_t bytes =
      VertexMatcher::bytes(a, b) + triangle_comparison_bytes(a.triangles.size() + b.triangles.size(), a.edges.size());
  const std::uint64_t triangles = a.triangles.size() + b.triangles.size();
  const auto memory = TRY(context.reserve(bytes, fmt::format("{}: comparing {} triangles", a.name, triangles)));

  VertexMatcher matcher(a, b);
  const MatchedVertices sums = matcher.run();
  ExtractionComparison result;
  result.vertices = {a.positions.size(), b.positions.size()};
  result.triangles = compare_triangle_sets({a, matcher.names_a()}, {b, matcher.names_b()}, a.edges.size());
  result.vertices_only = sums.only;
  result.vertex_example = sums.example;
  const bool any_vertices = !a.positions.empty() && !b.positions.empty();
  result.origins_differ = any_vertices && a.origin != b.origin;
  result.normals_in_one_only = any_vertices && a.normals.empty() != b.normals.empty();
  result.normals_compared = any_vertices && !a.normals.empty() && !b.normals.empty();
  result.ulps = sums.position.amount;
  result.farthest = sums.position.edge;
  result.degrees = sums.normal.amount;
  result.largest_angle_edge = sums.normal.edge;
  return result;
}

std::vector<std::string> differences(const ExtractionComparison& comparison, const MeshLabels& names) {
  std::vector<std::string> found;
  const auto add = [&](std::string sentence) { found.push_back(std::move(sentence)); };
  add_difference_sentences(comparison.triangles, names, found);
  for (std::size_t side = 0; side < 2; ++side) {
    if (const auto& example = comparison.vertex_example[side]) {
      add(fmt::format("{} of {} vertices are in {} only, one of them at sample {}", comparison.vertices_only[side],
                      comparison.vertices[side], names[side], edge_text(*example)));
    }
  }
  if (comparison.origins_differ) add("the meshes have different origins");
  if (comparison.normals_in_one_only) add("only one of the meshes has normals");
  if (!(comparison.ulps <= kStabilityUlps)) {
    add(fmt::format("a vertex differs by {:.3g} ulps, allowed {:.3g}, at sample {}", comparison.ulps, kStabilityUlps,
                    edge_text(*comparison.farthest)));
  }
  if (!(comparison.degrees <= kNormalDegrees)) {
    add(fmt::format("a normal differs by {:.3g} degrees, allowed {:.3g}, at sample {}", comparison.degrees,
                    kNormalDegrees, edge_text(*comparison.largest_angle_edge)));
  }
  return found;
}

std::string edge_text(const mesh::EdgeKey& edge) {
  std::string text = fmt::format("({}, {}, {})", edge.low.x, edge.low.y, edge.low.z);
  if (edge.direction == 0) return text;
  text += " along ";
  for (int axis = 0; axis < 3; ++axis) {
    if ((edge.direction >> axis & 1) != 0) text += "xyz"[axis];
  }
  return text;
}

}  // namespace isoextract::accuracy
