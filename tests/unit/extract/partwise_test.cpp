// A sink gets the same mesh, part by part, that an extraction without a sink returns.
#include <algorithm>
#include <cstring>
#include <functional>
#include <mutex>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "extract/dense_masks.hpp"
#include "mesh/coincident_vertices.hpp"
#include "mesh/partwise_measures.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"
#include "support/thread_ranks.hpp"

namespace isoextract::extract {
namespace {

const mesh::PartPass kPositions{.in_order = true, .normals = false, .triangles = false};
const mesh::PartPass kNormals{.in_order = true, .positions = false, .triangles = false};
const mesh::PartPass kTriangles{.in_order = true, .positions = false, .normals = false};

// Assembles the parts into a mesh, and checks that they cover it once, in order if the passes are.
class Assembler final : public mesh::MeshSink {
 public:
  Result<bool> begin(const mesh::MeshShape& shape) override {
    EXPECT_FALSE(shape_) << "begin() was called twice";
    shape_ = shape;
    if (!takes) return false;
    mesh.origin = shape.origin;
    mesh.positions = Buffer<glm::vec3>(shape.vertices);
    if (shape.has_normals) mesh.normals = Buffer<glm::vec3>(shape.vertices);
    mesh.triangles = Buffer<glm::uvec3>(shape.triangles);
    vertex_seen_.assign(shape.vertices, 0);
    triangle_seen_.assign(shape.triangles, 0);
    return true;
  }

  [[nodiscard]] std::vector<mesh::PartPass> passes() const override { return wanted; }

  Result<void> take(const mesh::MeshPart& part) override {
    const std::lock_guard lock(mutex_);
    if (++parts == fails_at) return fail(ErrorCode::output, "the disk is full");
    if (wanted.front().in_order) {
      EXPECT_TRUE(part.positions.empty() || part.first_vertex == positions_);
      EXPECT_TRUE(part.normals.empty() || part.first_vertex == normals_);
      EXPECT_TRUE(part.triangles.empty() || part.first_triangle == triangles_);
      EXPECT_FALSE(part.positions.empty() && part.normals.empty() && part.triangles.empty());
      EXPECT_LE(arrays_of(part), wanted.size() == 1 ? 3 : 1);
    } else {
      EXPECT_EQ(part.normals.size(), mesh.normals.empty() ? 0 : part.positions.size());
    }
    positions_ += part.positions.size();
    normals_ += part.normals.size();
    triangles_ += part.triangles.size();
    ends.push_back(positions_);
    triangle_ends.push_back(triangles_);
    copy(part.positions, mesh.positions, part.first_vertex);
    copy(part.normals, mesh.normals, part.first_vertex);
    copy(part.triangles, mesh.triangles, part.first_triangle);
    for (std::size_t v = 0; v < part.positions.size(); ++v) ++vertex_seen_[part.first_vertex + v];
    for (std::size_t t = 0; t < part.triangles.size(); ++t) ++triangle_seen_[part.first_triangle + t];
    return {};
  }

  [[nodiscard]] bool is_complete() const {
    const auto once = [](int seen) { return seen == 1; };
    return std::ranges::all_of(vertex_seen_, once) && std::ranges::all_of(triangle_seen_, once);
  }
  [[nodiscard]] const std::optional<mesh::MeshShape>& shape() const { return shape_; }

  std::vector<mesh::PartPass> wanted{mesh::PartPass()};
  std::vector<std::uint64_t> ends;           // of the vertices of each part
  std::vector<std::uint64_t> triangle_ends;  // of the triangles of each part
  bool takes = true;
  int fails_at = -1;  // number of the part that cannot be taken
  int parts = 0;
  mesh::Mesh mesh;

 private:
  static std::size_t arrays_of(const mesh::MeshPart& part) {
    return (part.positions.empty() ? 0U : 1U) + (part.normals.empty() ? 0U : 1U) + (part.triangles.empty() ? 0U : 1U);
  }

  template <class T>
  static void copy(std::span<const T> from, Buffer<T>& to, std::uint64_t first) {
    if (!from.empty()) std::memcpy(to.data() + first, from.data(), from.size_bytes());
  }

  std::mutex mutex_;
  std::optional<mesh::MeshShape> shape_;
  std::vector<int> vertex_seen_;
  std::vector<int> triangle_seen_;
  std::uint64_t positions_ = 0;  // taken until now
  std::uint64_t normals_ = 0;
  std::uint64_t triangles_ = 0;
};

// The sink of one rank. Passes its parts on to a sink of all ranks.
class RankSink final : public mesh::MeshSink {
 public:
  RankSink(Ranks& ranks, Assembler& all) : ranks_(ranks), all_(all) {}

  [[nodiscard]] Ranks* ranks() const override { return &ranks_; }
  Result<bool> begin(const mesh::MeshShape& shape) override {
    EXPECT_EQ(shape.vertices, all_.shape()->vertices);
    EXPECT_EQ(shape.triangles, all_.shape()->triangles);
    EXPECT_EQ(shape.may_be_open, all_.shape()->may_be_open);
    return true;
  }
  Result<void> take(const mesh::MeshPart& part) override { return all_.take(part); }

 private:
  Ranks& ranks_;
  Assembler& all_;
};

// Noise, with outside samples at the lowest and highest faces: all crossed edges begin in stored blocks.
field::ScalarField noise_in_blocks() {
  const field::ScalarField noise = test::random_field<float>({40, 48, 56}, 12, 1000);
  const auto* values = static_cast<const float*>(std::get<field::DenseSamples>(noise.samples).data);
  const auto within = test::dense_field<float>({40, 48, 56}, [&](int i, int j, int k) {
    const bool is_inner = std::min({i, j, k, 39 - i, 47 - j, 55 - k}) > 0;
    return is_inner ? values[i + 40 * (j + 48 * k)] : -1.0F;
  });
  return test::sparse_copy<float>(within, -1);
}

class Partwise : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, Partwise, testing::ValuesIn(test::cell_methods()), test::method_name);

TEST_P(Partwise, GivesSameMesh) {
  // 19 slices: two whole slabs and a part of one. The region begins within a slab.
  const field::ScalarField field = test::random_field<float>({70, 21, 19}, 3, 1000);
  for (const bool cap : {false, true}) {
    for (const bool normals : {false, true}) {
      for (const auto& region :
           {std::optional<field::IndexBox>(), std::optional(field::IndexBox{{3, 1, 5}, {60, 20, 17}})}) {
        ExtractOptions options = test::options_of(GetParam(), 500, cap);
        options.smooth_normals = normals;
        options.region = region;
        const Extraction whole = test::extract(field, options);
        EXPECT_FALSE(whole.taken);
        Assembler sink;
        options.sink = &sink;
        const Extraction taken = test::extract(field, options);
        ASSERT_TRUE(taken.taken);
        EXPECT_TRUE(taken.mesh.positions.empty() && taken.mesh.triangles.empty());
        EXPECT_GE(sink.parts, 2);
        EXPECT_TRUE(sink.is_complete());
        EXPECT_EQ(taken.taken->vertices, whole.mesh.positions.size());
        EXPECT_EQ(taken.taken->triangles, whole.mesh.triangles.size());
        EXPECT_EQ(taken.taken->may_be_open, !cap);
        EXPECT_TRUE(test::same_bytes(sink.mesh.positions, whole.mesh.positions));
        EXPECT_TRUE(test::same_bytes(sink.mesh.normals, whole.mesh.normals));
        EXPECT_TRUE(test::same_bytes(sink.mesh.triangles, whole.mesh.triangles));
      }
    }
  }
}

// Ranks have one slab each, unequally many slabs, or none. The last slab may be one slice.
TEST_P(Partwise, GivesSameMeshFromRanks) {
  for (const int slices : {9, 13, 17, 19, 40}) {
    const field::ScalarField field = test::random_field<float>({70, 21, slices}, 3, 1000);
    for (const bool cap : {false, true}) {
      for (const auto& region :
           {std::optional<field::IndexBox>(), std::optional(field::IndexBox{{3, 1, 2}, {60, 20, slices - 2}})}) {
        ExtractOptions options = test::options_of(GetParam(), 500, cap);
        options.region = region;
        const Extraction whole = test::extract(field, options);
        mesh::MeshShape shape = mesh::shape_of(whole.mesh);
        shape.may_be_open = !cap;
        Assembler all;
        ASSERT_TRUE(all.begin(shape));
        test::run_ranks([&](Ranks& ranks) {
          RankSink sink(ranks, all);
          ExtractOptions of_rank = options;
          of_rank.sink = &sink;
          EXPECT_TRUE(test::extract(field, of_rank).taken);
        });
        EXPECT_TRUE(all.is_complete());
        EXPECT_TRUE(test::same_bytes(all.mesh.positions, whole.mesh.positions));
        EXPECT_TRUE(test::same_bytes(all.mesh.triangles, whole.mesh.triangles));
      }
    }
  }
}

TEST_P(Partwise, GivesSameMeshInOrder) {
  const field::ScalarField field = test::random_field<float>({70, 21, 19}, 3, 1000);
  for (const bool cap : {false, true}) {
    for (const bool one_pass : {false, true}) {
      ExtractOptions options = test::options_of(GetParam(), 500, cap);
      options.smooth_normals = true;
      const Extraction whole = test::extract(field, options);
      Assembler sink;
      sink.wanted =
          one_pass ? std::vector{mesh::PartPass{.in_order = true}} : std::vector{kPositions, kNormals, kTriangles};
      options.sink = &sink;
      ASSERT_TRUE(test::extract(field, options).taken);
      EXPECT_TRUE(sink.is_complete());
      EXPECT_TRUE(test::same_bytes(sink.mesh.positions, whole.mesh.positions));
      EXPECT_TRUE(test::same_bytes(sink.mesh.normals, whole.mesh.normals));
      EXPECT_TRUE(test::same_bytes(sink.mesh.triangles, whole.mesh.triangles));
    }
  }
}

// A writer can write each part once it has the next one, if it keeps far vertices.
TEST_P(Partwise, LimitsTrianglesToOwnAndNextPartAndFarVertices) {
  const field::ScalarField dense = test::random_field<float>({20, 21, 39}, 7, 1000);
  const field::ScalarField sparse = noise_in_blocks();
  for (const auto& [field, cap] : {std::pair(&dense, false), {&dense, true}, {&sparse, false}}) {
    ExtractOptions options = test::options_of(GetParam(), 500, cap);
    Assembler sink;
    sink.wanted = {mesh::PartPass{.in_order = true}};
    options.sink = &sink;
    ASSERT_TRUE(test::extract(*field, options).taken);
    EXPECT_TRUE(sink.shape()->uses_near_vertices);
    const auto part_of = [&](std::uint32_t vertex) {
      return std::ranges::upper_bound(sink.ends, vertex) - sink.ends.begin();
    };
    const std::vector<std::uint32_t>& far = sink.shape()->far_vertices;
    EXPECT_EQ(far.empty(), !cap);
    EXPECT_TRUE(std::ranges::is_sorted(far, std::less_equal<>()));
    EXPECT_LT(far.size(), sink.mesh.positions.size());
    for (std::size_t t = 0; t < sink.mesh.triangles.size(); ++t) {
      const auto part = std::ranges::upper_bound(sink.triangle_ends, t) - sink.triangle_ends.begin();
      for (int corner = 0; corner < 3; ++corner) {
        const std::uint32_t vertex = sink.mesh.triangles[t][corner];
        const auto of_vertex = part_of(vertex) - part;
        ASSERT_TRUE(of_vertex == 0 || of_vertex == 1 || std::ranges::binary_search(far, vertex)) << t;
      }
    }
  }
}

void expect_equal(const mesh::Topology& a, const mesh::Topology& b) {
  EXPECT_EQ(a.edges, b.edges);
  EXPECT_EQ(a.open_edges, b.open_edges);
  EXPECT_EQ(a.nonmanifold_edges, b.nonmanifold_edges);
  EXPECT_EQ(a.misoriented_edges, b.misoriented_edges);
  EXPECT_EQ(a.nonmanifold_vertices, b.nonmanifold_vertices);
  EXPECT_EQ(a.unused_vertices, b.unused_vertices);
  EXPECT_EQ(a.repeated_index_triangles, b.repeated_index_triangles);
  EXPECT_EQ(a.components, b.components);
  EXPECT_EQ(a.euler, b.euler);
}

void expect_equal(const mesh::MeshMeasures& a, const mesh::MeshMeasures& b) {
  expect_equal(a.topology, b.topology);
  EXPECT_EQ(a.size.area, b.size.area);
  EXPECT_EQ(a.size.volume, b.size.volume);
  EXPECT_EQ(a.size.zero_area_triangles, b.size.zero_area_triangles);
  EXPECT_EQ(a.bounds.min, b.bounds.min);
  EXPECT_EQ(a.bounds.max, b.bounds.max);
  ASSERT_EQ(a.components.size(), b.components.size());
  for (std::size_t c = 0; c < a.components.size(); ++c) {
    const mesh::ComponentFacts& one = a.components[c];
    const mesh::ComponentFacts& other = b.components[c];
    expect_equal(one.topology, other.topology);
    EXPECT_EQ(one.triangles, other.triangles);
    EXPECT_EQ(one.area, other.area);
    EXPECT_EQ(one.volume, other.volume);
    EXPECT_EQ(one.bounds.min, other.bounds.min);
    EXPECT_EQ(one.bounds.max, other.bounds.max);
  }
}

// Of few samples inside, there are many components; of half of them, one reaches through all parts.
TEST_P(Partwise, MeasuresLikeTheWholeMesh) {
  const field::ScalarField field = test::random_field<float>({64, 41, 45}, 9, 1000);
  for (const bool cap : {false, true}) {
    for (const double iso : {500, 950}) {
      ExtractOptions options = test::options_of(GetParam(), iso, cap);
      const Extraction whole = test::extract(field, options);
      const auto expected = mesh::measure_mesh(whole.mesh, Context());
      ASSERT_TRUE(expected);
      EXPECT_GT(expected->components.size(), iso > 900 ? 500 : 5);
      EXPECT_GT(whole.mesh.triangles.size(), iso > 900 ? 1U << 15U : 1U << 17U);
      mesh::PartwiseMeasures sink("a mesh", Context());
      options.sink = &sink;
      ASSERT_TRUE(test::extract(field, options).taken);
      auto measures = sink.finish();
      ASSERT_TRUE(measures) << measures.error().message;
      expect_equal(*measures, *expected);
    }
  }
}

void expect_ranks_measure(const field::ScalarField& field, const ExtractOptions& options) {
  const auto expected = mesh::measure_mesh(test::extract(field, options).mesh, Context());
  ASSERT_TRUE(expected);
  test::run_ranks([&](Ranks& ranks) {
    mesh::PartwiseMeasures sink("a mesh", Context(), &ranks);
    ExtractOptions of_rank = options;
    of_rank.sink = &sink;
    ASSERT_TRUE(test::extract(field, of_rank).taken);
    const auto measures = sink.finish();
    ASSERT_TRUE(measures) << measures.error().message;
    expect_equal(*measures, *expected);
  });
}

// Components reach through several ranks, and sums of triangles begin and end in them.
TEST_P(Partwise, MeasuresLikeTheWholeMeshOnRanks) {
  for (const double iso : {500, 950}) {
    expect_ranks_measure(test::random_field<float>({64, 41, 45}, 9, 1000), test::options_of(GetParam(), iso));
  }
  // All triangles are in one range of the sums; the last rank has one slice, or the second one has none.
  for (const int slices : {9, 13, 17, 19, 25, 33}) {
    expect_ranks_measure(test::random_field<float>({20, 9, slices}, 9, 1000), test::options_of(GetParam(), 500));
  }
}

// Samples are inside only between two slices: the first or the last rank, or both, make no triangles.
TEST_P(Partwise, MeasuresOnRanksWithoutTriangles) {
  const field::ScalarField noise = test::random_field<float>({40, 21, 48}, 9, 1000);
  const auto* values = static_cast<const float*>(std::get<field::DenseSamples>(noise.samples).data);
  for (const auto& [begin, end] : {std::pair(0, 3), {20, 26}, {40, 47}, {14, 18}, {15, 33}, {16, 16}, {31, 32}}) {
    const auto field = test::dense_field<float>({40, 21, 48}, [&](int i, int j, int k) {
      return k >= begin && k <= end ? values[i + 40 * (j + 21 * k)] : -1.0F;
    });
    expect_ranks_measure(field, test::options_of(GetParam(), 500));
  }
}

TEST_P(Partwise, ReportsWhetherPositionsAreDistinct) {
  // Many values equal the iso value, so that vertices lie next to samples.
  const field::ScalarField field = test::random_field<std::uint8_t>({30, 30, 30}, 8, 4);
  const glm::dmat3 rotation(0.8, 0.6, 0, -0.36, 0.48, 0.8, 0.48, -0.64, 0.6);
  const glm::dmat3 flat(1e-3, 0, 0, 0, 1, 0, 0, 0, 1e3);
  const glm::dmat3 bricks(0.1, 0, 0, 0, 1, 0, 0, 0, 10);
  const glm::dmat3 shear(1, 1, 0, 1, 1.000001, 0, 0, 0, 1);  // x and y almost parallel
  for (const glm::dmat3& linear : {glm::dmat3(1), rotation, flat, rotation * bricks, shear}) {
    ExtractOptions options = test::options_of(GetParam(), 2, true);
    options.output_from_index.linear = linear;
    Assembler sink;
    options.sink = &sink;
    ASSERT_TRUE(test::extract(field, options).taken);
    EXPECT_EQ(sink.shape()->distinct_positions, linear != shear);
    const bool are_distinct = mesh::CoincidentVertices(sink.mesh.positions.span()).repeated() == 0;
    EXPECT_EQ(are_distinct, linear != shear);
  }
}

TEST_P(Partwise, MakesWholeMeshIfSinkDeclines) {
  const field::ScalarField field = test::random_field<std::uint8_t>({20, 20, 20}, 4, 255);
  ExtractOptions options = test::options_of(GetParam(), 100);
  Assembler sink;
  sink.takes = false;
  options.sink = &sink;
  const Extraction made = test::extract(field, options);
  EXPECT_TRUE(sink.shape());
  EXPECT_FALSE(made.taken);
  EXPECT_EQ(sink.parts, 0);
  test::expect_sound(made.mesh, false);
}

TEST_P(Partwise, GivesSameSparseMesh) {
  // Noise up to the faces of the blocks: cells below them have no block.
  const field::ScalarField full = test::sparse_copy<float>(test::random_field<float>({24, 32, 40}, 5, 1000), -1);
  const field::ScalarField inner = noise_in_blocks();
  for (const field::ScalarField* field : {&full, &inner}) {
    for (const bool cap : {false, true}) {
      ExtractOptions options = test::options_of(GetParam(), 500, cap);
      options.smooth_normals = true;
      if (cap) options.region = field::IndexBox{{3, 1, 5}, {22, 30, 37}};
      const Extraction whole = test::extract(*field, options);
      for (const bool in_order : {false, true}) {
        Assembler sink;
        if (in_order) sink.wanted = {kPositions, kNormals, kTriangles};
        options.sink = &sink;
        const Extraction taken = test::extract(*field, options);
        options.sink = nullptr;
        ASSERT_TRUE(taken.taken);
        EXPECT_GE(sink.parts, 3);
        EXPECT_TRUE(sink.is_complete());
        EXPECT_TRUE(test::same_bytes(sink.mesh.positions, whole.mesh.positions));
        EXPECT_TRUE(test::same_bytes(sink.mesh.normals, whole.mesh.normals));
        EXPECT_TRUE(test::same_bytes(sink.mesh.triangles, whole.mesh.triangles));
        EXPECT_TRUE(cap || sink.shape()->uses_near_vertices == (field == &inner));
      }
    }
  }
}

TEST_P(Partwise, MeasuresSparseMeshLikeTheWholeMesh) {
  const field::ScalarField field = noise_in_blocks();
  ExtractOptions options = test::options_of(GetParam(), 500);
  const auto expected = mesh::measure_mesh(test::extract(field, options).mesh, Context());
  ASSERT_TRUE(expected);
  mesh::PartwiseMeasures sink("a mesh", Context());
  options.sink = &sink;
  ASSERT_TRUE(test::extract(field, options).taken);
  const auto measures = sink.finish();
  ASSERT_TRUE(measures) << measures.error().message;
  expect_equal(*measures, *expected);
}

TEST_P(Partwise, OffersNoPartsOfKeyedOrEmptyMeshes) {
  field::ScalarField dense = test::random_field<float>({24, 24, 24}, 5, 1000);
  Assembler sink;
  ExtractOptions options = test::options_of(GetParam(), 500);
  options.sink = &sink;
  options.edge_keys = true;
  EXPECT_FALSE(test::extract(dense, options).taken);
  options.edge_keys = false;
  options.iso = 5000;  // no surface
  EXPECT_FALSE(test::extract(dense, options).taken);
  EXPECT_FALSE(sink.shape());
}

TEST_P(Partwise, FailsIfSinkFails) {
  const field::ScalarField field = test::random_field<float>({20, 20, 64}, 6, 1000);
  Assembler sink;
  sink.fails_at = 3;
  ExtractOptions options = test::options_of(GetParam(), 500);
  options.sink = &sink;
  const auto made = make_cpu_extractor()->extract(field, options, Context());
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().message, "the disk is full");
}

// Where masks of all samples would take more than half of the memory, samples are compared slab by slab, twice.
class Slabs : public Partwise {
 protected:
  static constexpr std::uint64_t kLittle = 8'000'000;  // masks of all samples take 4,176,000 bytes

  static field::ScalarField balls(bool with_nan = false) {
    return test::dense_field<float>({300, 300, 290}, [&](int i, int j, int k) {
      if (with_nan && i == 7 && j == 8 && k == 285) return test::kNaN;
      const auto ball = [&](const glm::dvec3& center, double radius) {
        return radius - glm::length(glm::dvec3(i, j, k) - center);
      };
      return std::max({ball({70, 80, 61}, 33), ball({200, 190, 287}, 21), ball({299, 4, 150}, 9)});
    });
  }
};
INSTANTIATE_TEST_SUITE_P(Methods, Slabs, testing::ValuesIn(test::cell_methods()), test::method_name);

TEST_P(Slabs, GiveSameMesh) {
  const field::ScalarField field = balls();
  for (const bool cap : {false, true}) {
    ASSERT_GT(DenseMasks::bytes({300, 300, 290}), kLittle / 2);
    ExtractOptions options = test::options_of(GetParam(), 0, cap);
    options.smooth_normals = true;
    const Extraction whole = test::extract(field, options);
    const auto extract = [&] {
      const Context little(MemoryBudget{kLittle});
      auto made = make_cpu_extractor()->extract(field, options, little);
      if (!made) throw std::runtime_error(made.error().message);
      EXPECT_EQ(made->stats.samples_classified, whole.stats.samples_classified);
      EXPECT_EQ(made->stats.bricks_visited, whole.stats.bricks_visited);
      EXPECT_EQ(made->stats.meets_boundary, whole.stats.meets_boundary);
      EXPECT_EQ(made->stats.inside_at_boundary, whole.stats.inside_at_boundary);
      return std::move(*made);
    };
    const Extraction made = extract();
    EXPECT_TRUE(test::same_bytes(made.mesh.positions, whole.mesh.positions));
    EXPECT_TRUE(test::same_bytes(made.mesh.normals, whole.mesh.normals));
    EXPECT_TRUE(test::same_bytes(made.mesh.triangles, whole.mesh.triangles));
    for (const bool in_order : {false, true}) {
      Assembler sink;
      if (in_order) sink.wanted = {kPositions, kNormals, kTriangles};
      options.sink = &sink;
      ASSERT_TRUE(extract().taken);
      EXPECT_TRUE(sink.is_complete());
      EXPECT_TRUE(test::same_bytes(sink.mesh.positions, whole.mesh.positions));
      EXPECT_TRUE(test::same_bytes(sink.mesh.normals, whole.mesh.normals));
      EXPECT_TRUE(test::same_bytes(sink.mesh.triangles, whole.mesh.triangles));
    }
  }
}

TEST_P(Slabs, FindNan) {
  const field::ScalarField field = balls(true);
  for (const double iso : {0.0, 1e30}) {  // nothing is above the largest number
    ExtractOptions options = test::options_of(GetParam(), iso);
    const Context little(MemoryBudget{kLittle});
    const auto refused = make_cpu_extractor()->extract(field, options, little);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::input);
    EXPECT_NE(refused.error().message.find("(7, 8, 285)"), std::string::npos) << refused.error().message;
    options.nan = NanPolicy::outside;
    const auto made = make_cpu_extractor()->extract(field, options, little);
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(made->mesh.triangles.empty(), iso > 0);
  }
}

}  // namespace
}  // namespace isoextract::extract
