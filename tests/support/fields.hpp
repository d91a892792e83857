// Fields for tests: dense ones by formula, and sparse ones with the same values.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <tuple>
#include <vector>

#include "field/scalar_field.hpp"

namespace isoextract::test {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// half can only be constructed from float.
template <class T, class V>
T sample(V value) {
  if constexpr (std::is_same_v<T, field::Half>) {
    return field::Half(static_cast<float>(value));
  } else {
    return static_cast<T>(value);
  }
}

// Returns a dense field with value(i, j, k) at every sample; index space equals world space.
template <class T, class F>
field::ScalarField dense_field(const glm::ivec3& dims, const F& value) {
  auto values = std::make_shared<std::vector<T>>();
  for (int k = 0; k < dims.z; ++k) {
    for (int j = 0; j < dims.y; ++j) {
      for (int i = 0; i < dims.x; ++i) values->push_back(sample<T>(value(i, j, k)));
    }
  }
  field::ScalarField field;
  field.name = "test";
  field.source = "test field";
  const void* data = values->data();
  field.samples = field::DenseSamples{field::sample_type_of<T>(), dims, std::move(values), data};
  return field;
}

template <class T>
field::ScalarField random_field(const glm::ivec3& dims, unsigned seed, int distinct_values) {
  std::mt19937 engine(seed);
  std::uniform_int_distribution<int> value(0, distinct_values - 1);
  return dense_field<T>(dims, [&](int, int, int) { return value(engine); });
}

// Returns a sparse field with the same values: 8^3 blocks, tiles for constant blocks, and `background` for blocks of
// that value. The first and the last block are always stored, so that the stored box is the dense box. Dims must be
// multiples of 8.
template <class T>
field::ScalarField sparse_copy(const field::ScalarField& field, double background) {
  const auto& dense = std::get<field::DenseSamples>(field.samples);
  const auto* source = static_cast<const T*>(dense.data);
  auto values = std::make_shared<std::vector<std::vector<T>>>();
  field::SparseSamples sparse;
  sparse.type = dense.type;
  sparse.background = background;
  const glm::ivec3 last = dense.dims - 8;
  for (int x = 0; x < dense.dims.x; x += 8) {
    for (int y = 0; y < dense.dims.y; y += 8) {
      for (int z = 0; z < dense.dims.z; z += 8) {
        std::vector<T> block;
        for (int v = 0; v < 512; ++v) {
          const glm::i64vec3 p = glm::i64vec3(x, y, z) + glm::i64vec3(v >> 6, v >> 3 & 7, v & 7);
          block.push_back(source[p.x + dense.dims.x * (p.y + dense.dims.y * p.z)]);
        }
        const glm::ivec3 origin(x, y, z);
        const bool constant = std::all_of(block.begin(), block.end(), [&](T v) { return v == block[0]; });
        if (constant && origin != glm::ivec3(0) && origin != last) {
          const auto value = static_cast<double>(block[0]);
          if (value != background) sparse.tiles.push_back({origin, 8, value});
          continue;
        }
        sparse.blocks.push_back({origin, nullptr});
        values->push_back(std::move(block));
      }
    }
  }
  for (std::size_t b = 0; b < values->size(); ++b) sparse.blocks[b].values = (*values)[b].data();
  sparse.active_box = {glm::ivec3(0), dense.dims - 1};
  sparse.owner = std::move(values);
  field::ScalarField result = field;
  result.samples = std::move(sparse);
  return result;
}

// Returns a sparse field of zeros with a row of blocks, each with a single 1. From 128 samples apart, each needs a
// SparseLookup::Node of its own.
inline field::ScalarField row_of_blocks(int count, int apart) {
  auto values = std::make_shared<std::vector<float>>(512, 0.0F);
  (*values)[3 << 6 | 3 << 3 | 3] = 1;
  field::SparseSamples sparse;
  for (int b = 0; b < count; ++b) sparse.blocks.push_back({glm::ivec3(apart * b, 0, 0), values->data()});
  sparse.active_box = {glm::ivec3(0), glm::ivec3(apart * (count - 1) + 7, 7, 7)};
  sparse.owner = std::move(values);
  field::ScalarField field;
  field.source = "row of blocks";
  field.samples = std::move(sparse);
  return field;
}

}  // namespace isoextract::test
