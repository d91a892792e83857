// A sink gets the same mesh, part by part, that an extraction without a sink returns.
#include <cstring>
#include <mutex>

#include <gtest/gtest.h>

#include "extract/dense_masks.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

// Assembles the parts into a mesh, and checks that they cover it once.
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

  Result<void> take(const mesh::MeshPart& part) override {
    const std::lock_guard lock(mutex_);
    if (++parts == fails_at) return fail(ErrorCode::output, "the disk is full");
    copy(part.positions, mesh.positions, part.first_vertex);
    EXPECT_EQ(part.normals.size(), mesh.normals.empty() ? 0 : part.positions.size());
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

  bool takes = true;
  int fails_at = -1;  // number of the part that cannot be taken
  int parts = 0;
  mesh::Mesh mesh;

 private:
  template <class T>
  static void copy(std::span<const T> from, Buffer<T>& to, std::uint64_t first) {
    if (!from.empty()) std::memcpy(to.data() + first, from.data(), from.size_bytes());
  }

  std::mutex mutex_;
  std::optional<mesh::MeshShape> shape_;
  std::vector<int> vertex_seen_;
  std::vector<int> triangle_seen_;
};

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

TEST_P(Partwise, OffersNoMeshThatIsEditedAsWhole) {
  field::ScalarField dense = test::random_field<float>({20, 20, 20}, 5, 1000);
  const field::ScalarField sparse = test::sparse_copy<float>(dense, -1);
  Assembler sink;
  ExtractOptions options = test::options_of(GetParam(), 500);
  options.sink = &sink;
  EXPECT_FALSE(test::extract(sparse, options).taken);
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
    Assembler sink;
    options.sink = &sink;
    ASSERT_TRUE(extract().taken);
    EXPECT_TRUE(sink.is_complete());
    EXPECT_TRUE(test::same_bytes(sink.mesh.positions, whole.mesh.positions));
    EXPECT_TRUE(test::same_bytes(sink.mesh.normals, whole.mesh.normals));
    EXPECT_TRUE(test::same_bytes(sink.mesh.triangles, whole.mesh.triangles));
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
