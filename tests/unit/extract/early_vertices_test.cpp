// A sink may get vertices while the extraction still counts; the mesh is the same as without them.
#include <algorithm>
#include <cstring>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "extract/detail/early_vertices.hpp"
#include "extract/detail/slab_countdown.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

using Control = tbb::global_control;

// Takes early vertices and assembles the mesh.
class EarlySink final : public mesh::MeshSink {
 public:
  Result<bool> begin_early(const mesh::MeshShape& estimate_of_mesh) override {
    EXPECT_FALSE(estimate) << "begin_early() was called twice";
    EXPECT_FALSE(shape);
    estimate = estimate_of_mesh;
    return takes_early;
  }
  Result<bool> begin(const mesh::MeshShape& shape_of_mesh) override {
    shape = shape_of_mesh;
    resize(shape->vertices);
    mesh.triangles = Buffer<glm::uvec3>(shape->triangles);
    return takes;
  }
  Result<void> take(const mesh::MeshPart& part) override {
    const std::lock_guard lock(mutex_);
    EXPECT_TRUE(estimate || shape);
    if (!shape) {
      if (early_vertices > 0 && fails) return fail(ErrorCode::output, "the disk is full");
      EXPECT_TRUE(part.triangles.empty());
      early_vertices += part.positions.size();
      resize(std::max<std::size_t>(positions_.size(), part.first_vertex + part.positions.size()));
    }
    for (std::size_t v = 0; v < part.positions.size(); ++v) ++times_[part.first_vertex + v];
    std::ranges::copy(part.positions, positions_.begin() + static_cast<std::ptrdiff_t>(part.first_vertex));
    std::ranges::copy(part.normals, normals_.begin() + static_cast<std::ptrdiff_t>(part.first_vertex));
    std::ranges::copy(part.triangles, mesh.triangles.begin() + part.first_triangle);
    return {};
  }

  // Expects that each vertex came once, and that the mesh is equal to the other.
  void expect_equal(const mesh::Mesh& other) const {
    EXPECT_TRUE(std::ranges::all_of(times_, [](int times) { return times == 1; }));
    ASSERT_EQ(positions_.size(), other.positions.size());
    EXPECT_EQ(std::memcmp(positions_.data(), other.positions.data(), other.positions.size_bytes()), 0);
    if (!other.normals.empty()) {
      EXPECT_EQ(std::memcmp(normals_.data(), other.normals.data(), other.normals.size_bytes()), 0);
    }
    EXPECT_TRUE(test::same_bytes(mesh.triangles, other.triangles));
  }

  bool takes_early = true;
  bool takes = true;
  bool fails = false;  // at the second early part
  std::optional<mesh::MeshShape> estimate;
  std::optional<mesh::MeshShape> shape;
  std::size_t early_vertices = 0;
  mesh::Mesh mesh;

 private:
  void resize(std::size_t vertices) {
    positions_.resize(vertices);
    normals_.resize(vertices);
    times_.resize(vertices);
  }

  std::mutex mutex_;
  std::vector<glm::vec3> positions_, normals_;
  std::vector<int> times_;
};

field::ScalarField noise() { return test::random_field<float>({70, 61, 75}, 3, 1000); }

class Early : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, Early, testing::ValuesIn(test::cell_methods()), test::method_name);

TEST_P(Early, GivesSameMesh) {
  const field::ScalarField field = noise();
  for (const std::size_t threads : {1U, 2U, 4U}) {
    const Control control(Control::max_allowed_parallelism, threads);
    for (const bool cap : {false, true}) {
      for (const bool normals : {false, true}) {
        for (const auto& region :
             {std::optional<field::IndexBox>(), std::optional(field::IndexBox{{3, 1, 5}, {67, 60, 70}})}) {
          ExtractOptions options = test::options_of(GetParam(), 500, cap);
          options.smooth_normals = normals;
          options.region = region;
          const Extraction whole = test::extract(field, options);
          EarlySink sink;
          options.sink = &sink;
          ASSERT_TRUE(test::extract(field, options).taken);
          sink.expect_equal(whole.mesh);
          EXPECT_LT(sink.early_vertices, whole.mesh.positions.size());  // those before the estimate are late
          if (threads > 1) continue;                                    // they may leave all to the later pass
          EXPECT_GT(sink.early_vertices, whole.mesh.positions.size() / 2);
          ASSERT_TRUE(sink.estimate);
          EXPECT_EQ(sink.estimate->has_normals, normals);
          const auto vertices = static_cast<double>(whole.mesh.positions.size());
          EXPECT_NEAR(static_cast<double>(sink.estimate->vertices), vertices, 0.2 * vertices);
        }
      }
    }
  }
}

TEST_P(Early, GivesWholeMeshIfTheSinkDeclines) {
  const Control control(Control::max_allowed_parallelism, 1);
  const field::ScalarField field = noise();
  ExtractOptions options = test::options_of(GetParam(), 500);
  const Extraction whole = test::extract(field, options);
  for (const bool takes_early : {false, true}) {
    EarlySink sink;
    sink.takes_early = takes_early;
    sink.takes = false;
    options.sink = &sink;
    const Extraction declined = test::extract(field, options);
    EXPECT_FALSE(declined.taken);
    EXPECT_EQ(sink.early_vertices > 0, takes_early);
    EXPECT_TRUE(test::same_bytes(declined.mesh.positions, whole.mesh.positions));
    EXPECT_TRUE(test::same_bytes(declined.mesh.triangles, whole.mesh.triangles));
  }
  EarlySink sink;
  sink.takes_early = false;
  options.sink = &sink;
  ASSERT_TRUE(test::extract(field, options).taken);
  EXPECT_EQ(sink.early_vertices, 0U);
  sink.expect_equal(whole.mesh);
}

TEST_P(Early, FailsLikeTheSink) {
  const Control control(Control::max_allowed_parallelism, 1);
  const field::ScalarField field = noise();
  ExtractOptions options = test::options_of(GetParam(), 500);
  EarlySink sink;
  sink.fails = true;
  options.sink = &sink;
  const auto made = make_cpu_extractor()->extract(field, options, Context());
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().message, "the disk is full");
}

// NaN samples are known only after some vertices; with smooth normals their mesh needs a pass over the whole.
TEST_P(Early, MakesMeshesWithNanSamplesWhole) {
  const Control control(Control::max_allowed_parallelism, 1);
  const field::ScalarField numbers = noise();
  const auto* values = static_cast<const float*>(std::get<field::DenseSamples>(numbers.samples).data);
  const auto field = test::dense_field<float>({70, 61, 75}, [&](int i, int j, int k) {
    return i == 30 && j == 40 && k == 70 ? std::numeric_limits<float>::quiet_NaN() : values[i + 70 * (j + 61 * k)];
  });
  for (const NanPolicy policy : {NanPolicy::outside, NanPolicy::hole}) {
    ExtractOptions options = test::options_of(GetParam(), 500);
    options.smooth_normals = true;
    options.nan = policy;
    const Extraction whole = test::extract(field, options);
    EarlySink sink;
    options.sink = &sink;
    const Extraction made = test::extract(field, options);
    EXPECT_FALSE(made.taken);
    EXPECT_EQ(sink.early_vertices > 0, policy == NanPolicy::outside);
    EXPECT_TRUE(test::same_bytes(made.mesh.positions, whole.mesh.positions));
    EXPECT_TRUE(test::same_bytes(made.mesh.normals, whole.mesh.normals));
    EXPECT_TRUE(test::same_bytes(made.mesh.triangles, whole.mesh.triangles));
  }
  ExtractOptions options = test::options_of(GetParam(), 500);
  EarlySink sink;
  options.sink = &sink;
  const auto refused = make_cpu_extractor()->extract(field, options, Context());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("(30, 40, 70)"), std::string::npos) << refused.error().message;
  EXPECT_FALSE(sink.shape);
}

// Slabs are counted one after another.
class EarlyVerticesOfSlabs : public testing::Test {
 protected:
  EarlyVerticesOfSlabs() { options.sink = &sink; }

  EarlySink sink;
  const field::ScalarField volume = noise();
  ExtractOptions options = test::options_of(Method::mc, 500);
  const OutputPlacement placement = output_placement(volume, options, volume.extents(), volume.extents());
};

// The vertices of a slab that finds no memory come later.
TEST_F(EarlyVerticesOfSlabs, LeavesOutSlabsWithoutMemory) {
  const Context context{MemoryBudget(std::uint64_t{4} << 20U)};
  EarlyVertices early(volume, options, context, placement, 4, true);
  std::vector<int> written, left;
  const auto add = [&](int slab, const MeshSizes& sizes) {
    const auto write = [&](int of, mesh::Mesh& part) {
      written.push_back(of);
      std::ranges::fill(part.positions, glm::vec3(1, 2, 3));
    };
    return early.add(slab, sizes, write, [&](int of) { left.push_back(of); });
  };
  ASSERT_TRUE(add(0, {30000, 50000}));
  ASSERT_TRUE(sink.estimate);
  EXPECT_EQ(sink.estimate->vertices, 120000U);
  EXPECT_EQ(sink.estimate->triangles, 200000U);
  ASSERT_TRUE(add(2, {1000, 50000}));
  EXPECT_TRUE(written.empty()) << "the first vertex of slab 2 is unknown";
  EXPECT_EQ(left, (std::vector{0, 2}));
  ASSERT_TRUE(add(1, {400000, 50000}));
  EXPECT_EQ(written, std::vector{2});
  EXPECT_EQ(left, (std::vector{0, 2, 1, 2}));
  ASSERT_TRUE(add(3, {2000, 50000}));
  EXPECT_EQ(early.finish(), 3000U);
  for (int slab = 0; slab < 4; ++slab) EXPECT_EQ(early.is_delivered(slab), slab > 1);
}

// Arrays for each slab, in unequal sizes, fill the heap: a process took twice the memory.
TEST_F(EarlyVerticesOfSlabs, SlabsUseTheSameArrays) {
  const Context context;
  const std::uint64_t all = context.memory().left();
  EarlyVertices early(volume, options, context, placement, 6, true);
  std::vector<const glm::vec3*> arrays;
  const auto add = [&](int slab, std::uint64_t vertices) {
    const auto write = [&](int /*slab*/, mesh::Mesh& part) {
      ASSERT_GE(part.positions.size(), vertices);
      std::ranges::fill(part.positions, glm::vec3(1, 2, 3));
      arrays.push_back(part.positions.data());
    };
    return early.add(slab, {vertices, 2 * vertices}, write, [](int /*slab*/) {});
  };
  for (const std::uint64_t vertices : {30000, 1000, 1100, 900, 5000, 3000}) {
    ASSERT_TRUE(add(static_cast<int>(arrays.size()) + (sink.estimate ? 1 : 0), vertices));
    EXPECT_EQ(context.memory().left() < all, !arrays.empty()) << "they stay for the next slab";
  }
  ASSERT_EQ(arrays.size(), 5U);
  EXPECT_EQ(arrays[1], arrays[0]) << "a tenth larger";
  EXPECT_EQ(arrays[2], arrays[0]);
  EXPECT_EQ(arrays[4], arrays[3]);
  EXPECT_EQ(early.finish(), 11000U);
  EXPECT_EQ(context.memory().left(), all) << "finish() frees them";
}

// A surface with more vertices than indices can number is refused before they are written.
TEST_F(EarlyVerticesOfSlabs, EndWithTheIndices) {
  const Context context;
  EarlyVertices early(volume, options, context, placement, 3, true);
  const auto add = [&](int slab, std::uint64_t vertices) {
    return early.add(
        slab, {vertices, 2 * vertices}, [](int /*slab*/, mesh::Mesh& /*part*/) {}, [](int /*slab*/) {});
  };
  ASSERT_TRUE(add(0, 30000));
  ASSERT_TRUE(sink.estimate);
  ASSERT_TRUE(add(1, std::uint64_t{1} << 32U));
  ASSERT_TRUE(add(2, 30000));
  EXPECT_EQ(early.finish(), 0U);
}

TEST(SlabCountdown, TellsOfEachSlabOnce) {
  for (const int slices : {1, 8, 9, 16, 17, 30}) {
    std::vector<int> order(static_cast<std::size_t>(slices));
    for (int i = 0; i < slices; ++i) order[static_cast<std::size_t>(i)] = i;
    std::ranges::reverse(order.begin() + slices / 3, order.end());
    SlabCountdown countdown(slices);
    std::vector<int> complete;
    std::vector<char> has_come(static_cast<std::size_t>(slices), 0);
    for (const int k : order) {
      has_come[static_cast<std::size_t>(k)] = 1;
      countdown.tell(k, [&](int slab) {
        complete.push_back(slab);
        for (int s = 8 * slab; s < std::min(8 * slab + 9, slices); ++s) {
          EXPECT_TRUE(has_come[static_cast<std::size_t>(s)]);
        }
      });
    }
    std::ranges::sort(complete);
    ASSERT_EQ(complete.size(), static_cast<std::size_t>((slices + 7) / 8));
    for (std::size_t slab = 0; slab < complete.size(); ++slab) EXPECT_EQ(complete[slab], static_cast<int>(slab));
  }
}

}  // namespace
}  // namespace isoextract::extract
