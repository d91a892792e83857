#include "field/dense_field.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

namespace isoextract::field {
namespace {

// One block at (8, 0, -8) with the value of its index, except sample (9, 1, -6), over a background of -1.
ScalarField one_block() {
  auto values = std::make_shared<std::vector<float>>(512, -1.0F);
  (*values)[(1 << 6) | (1 << 3) | 2] = 5;
  SparseSamples sparse;
  sparse.blocks.push_back({{8, 0, -8}, values->data()});
  sparse.background = -1;
  sparse.active_box = {{9, 1, -6}, {10, 1, -6}};
  sparse.owner = values;
  ScalarField field;
  field.source = "one";
  field.index_to_world = {glm::dmat3(0.5), glm::dvec3(10, 20, 30)};
  field.samples = std::move(sparse);
  return field;
}

TEST(DenseField, CoversActiveVoxelsAndOneMore) {
  const auto made = as_dense(one_block(), SampleType::f32, Context());
  ASSERT_TRUE(made) << made.error().message;
  const auto& dense = std::get<DenseSamples>(made->samples);
  EXPECT_EQ(dense.dims, glm::ivec3(4, 3, 3));
  const float* const values = static_cast<const float*>(dense.data);
  for (std::size_t i = 0; i < dense.count(); ++i) EXPECT_EQ(values[i], i == 1 + 4 * (1 + 3 * 1) ? 5.0F : -1.0F) << i;
  EXPECT_EQ(made->index_to_world.offset, glm::dvec3(10 + 0.5 * 8, 20, 30 + 0.5 * -7));
  ASSERT_EQ(made->notes.size(), 1U);
  EXPECT_EQ(made->notes.front().id, NoteId::sparse_made_dense);
}

TEST(DenseField, AppliesTheScale) {
  const std::vector<std::uint16_t> stored{0, 1, 65535, 7};
  DenseSamples samples;
  samples.type = SampleType::u16;
  samples.dims = {2, 2, 1};
  samples.data = stored.data();
  ScalarField field;
  field.samples = samples;
  field.scale = {0.5, -3};
  const auto made = as_dense(field, SampleType::f32, Context());
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_TRUE(made->scale.is_identity());
  const float* const values = static_cast<const float*>(std::get<DenseSamples>(made->samples).data);
  EXPECT_EQ(std::vector<float>(values, values + 4), (std::vector<float>{-3, -2.5, 32764.5, 0.5}));
  field.scale = {};
  const auto shared = as_dense(field, SampleType::u16, Context());
  ASSERT_TRUE(shared);
  EXPECT_EQ(std::get<DenseSamples>(shared->samples).data, stored.data()) << "nothing to convert";
}

TEST(DenseField, ReservesItsMemory) {
  ScalarField field = one_block();
  auto& sparse = std::get<SparseSamples>(field.samples);
  sparse.active_box.max = {1 << 20, 1 << 20, 1 << 20};
  const auto made = as_dense(field, SampleType::f32, Context(MemoryBudget(1 << 30)));
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::out_of_memory);
  sparse.active_box.min.x = -2000000000;
  sparse.active_box.max.x = 2000000000;
  EXPECT_EQ(as_dense(field, SampleType::f32, Context()).error().code, ErrorCode::input);
}

}  // namespace
}  // namespace isoextract::field
