// The bytes do not depend on the number of threads.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

class Threads : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, Threads, testing::ValuesIn(test::all_methods()), test::method_name);

TEST_P(Threads, DoNotChangeBytes) {
  const field::ScalarField dense = test::random_field<float>({72, 64, 64}, 2, 100);
  const field::ScalarField sparse = test::sparse_copy<float>(dense, -1);
  for (const field::ScalarField* field : {&dense, &sparse}) {
    ExtractOptions options = test::options_of(GetParam(), 70, true);
    options.smooth_normals = test::traits_of(GetParam()).gradient_normals;
    std::optional<mesh::Mesh> first;
    for (const std::size_t threads : {1U, 2U, 5U}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      mesh::Mesh mesh = test::extract(*field, options).mesh;
      if (!first) {
        EXPECT_FALSE(mesh.triangles.empty());
        first = std::move(mesh);
        continue;
      }
      EXPECT_TRUE(test::same_bytes(first->positions, mesh.positions));
      EXPECT_TRUE(test::same_bytes(first->normals, mesh.normals));
      EXPECT_TRUE(test::same_bytes(first->triangles, mesh.triangles));
    }
  }
}

}  // namespace
}  // namespace isoextract::extract
