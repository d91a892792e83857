// An extraction reserves its memory as long as it uses it, and stops when cancelled.
#include <limits>

#include <gtest/gtest.h>

#include "extract/extractor.hpp"
#include "support/fields.hpp"
#include "support/methods.hpp"

namespace isoextract::extract {
namespace {

struct Asked {
  Method method;
  bool sparse;
  bool cap;
  NanPolicy nan;
};

class Memory : public testing::TestWithParam<Asked> {
 protected:
  Memory() {
    options_ = test::options_of(GetParam().method, 0, GetParam().cap);
    options_.nan = GetParam().nan;
    options_.smooth_normals = test::traits_of(GetParam().method).gradient_normals;
    options_.edge_keys = test::traits_of(GetParam().method).vertices_on_edges;
    const bool holes = options_.nan == NanPolicy::hole;
    field_ = test::dense_field<float>({64, 48, 40}, [&](int i, int j, int k) {
      if (holes && i == 30 && j == 24) return std::numeric_limits<double>::quiet_NaN();
      return 18 - glm::length(glm::dvec3(i - 31.5, j - 23.5, k - (GetParam().cap ? 4 : 19.5)));
    });
    if (GetParam().sparse) field_ = test::sparse_copy<float>(field_, -100);
    if (GetParam().sparse && GetParam().cap) options_.region = field::IndexBox{glm::ivec3(0), {63, 47, 39}};
  }

  // Returns the bytes of the arrays of a mesh.
  static std::uint64_t bytes_of(const mesh::Mesh& mesh) {
    return mesh.positions.size_bytes() + mesh.normals.size_bytes() + mesh.edges.size_bytes() +
           mesh.triangles.size_bytes();
  }

  field::ScalarField field_;
  ExtractOptions options_;
};

std::vector<Asked> all_asked() {
  std::vector<Asked> all;
  for (const Method method : test::all_methods()) {
    for (const bool sparse : {false, true}) {
      for (const bool cap : {false, true}) all.push_back({method, sparse, cap, NanPolicy::error});
    }
    if (!test::traits_of(method).always_closed) all.push_back({method, false, false, NanPolicy::hole});
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Fields, Memory, testing::ValuesIn(all_asked()), [](const auto& parameter) {
  const Asked& asked = parameter.param;
  return test::identifier_of(asked.method) + (asked.sparse ? "_sparse" : "_dense") + (asked.cap ? "_cap" : "") +
         (asked.nan == NanPolicy::hole ? "_hole" : "");
});

TEST_P(Memory, StaysReservedWhileMeshLives) {
  const Context context(MemoryBudget(1 << 30));
  {
    const auto extraction = make_cpu_extractor()->extract(field_, options_, context);
    ASSERT_TRUE(extraction) << extraction.error().message;
    const mesh::Mesh& mesh = extraction->mesh;
    ASSERT_FALSE(mesh.triangles.empty());
    EXPECT_EQ(mesh.memory.bytes(), bytes_of(mesh));
    EXPECT_EQ(context.memory().reserved(), bytes_of(mesh)) << "only the mesh is left";
    // Peak memory: the mesh, at least one bit a sample, and not many times the mesh.
    const std::uint64_t bits = GetParam().sparse ? 64 : std::uint64_t{2} * 48 * 40 * 8;
    EXPECT_GE(context.memory().peak(), bytes_of(mesh) + bits);
    EXPECT_LE(context.memory().peak(), 4 * bytes_of(mesh) + 8 * bits + (1 << 18));
  }
  EXPECT_EQ(context.memory().reserved(), 0U);
}

TEST_P(Memory, RefusesLimitBelowPeak) {
  const Context free(MemoryBudget(1 << 30));
  ASSERT_TRUE(make_cpu_extractor()->extract(field_, options_, free));
  const std::uint64_t peak = free.memory().peak();
  const Context enough(MemoryBudget{peak});
  // Splitting vertices into fans checks its needs against the limit without reserving them.
  if (options_.nan != NanPolicy::hole) {
    EXPECT_TRUE(make_cpu_extractor()->extract(field_, options_, enough));
  }
  const Context little(MemoryBudget{peak - 1});
  const auto refused = make_cpu_extractor()->extract(field_, options_, little);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::out_of_memory);
  EXPECT_EQ(refused.error().hint, Hint(Remedy::raise, Setting::memory_limit)) << refused.error().message;
  EXPECT_EQ(little.memory().reserved(), 0U);
}

TEST_P(Memory, ReleasesAllAfterCancel) {
  const Context context;
  context.cancel();
  const auto refused = make_cpu_extractor()->extract(field_, options_, context);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::cancelled);
  EXPECT_EQ(context.memory().reserved(), 0U);
}

}  // namespace
}  // namespace isoextract::extract
