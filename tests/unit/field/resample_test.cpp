#include "field/resample.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "field/interpolant.hpp"
#include "support/fields.hpp"

namespace isoextract::field {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

const DenseSamples& dense_samples(const ScalarField& field) { return std::get<DenseSamples>(field.samples); }

constexpr ResampleKernel kLinear = ResampleKernel::linear;

ScalarField resampled(const ScalarField& field, const glm::ivec3& resolution, ResampleKernel kernel = kLinear,
                      NanHandling nan = NanHandling::left_out) {
  ScalarField result = resample(field, resolution, kernel, nan, Context()).value();
  EXPECT_EQ(dense_samples(result).dims, resolution);
  return result;
}

// Returns the stored value, whatever the type.
double sample_at(const ScalarField& field, const glm::ivec3& p) {
  const DenseSamples& samples = dense_samples(field);
  const glm::i64vec3 dims(samples.dims);
  return visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) {
    return static_cast<double>(static_cast<const T*>(samples.data)[p.x + dims.x * (p.y + dims.y * p.z)]);
  });
}

template <class F>
void for_each_sample(const glm::ivec3& dims, const F& visit) {
  for (int k = 0; k < dims.z; ++k) {
    for (int j = 0; j < dims.y; ++j) {
      for (int i = 0; i < dims.x; ++i) visit(glm::ivec3(i, j, k));
    }
  }
}

// Resamples a row along x, in a field that is constant along y and z.
std::vector<double> row_of(const std::vector<double>& samples, int count, ResampleKernel kernel = kLinear,
                           NanHandling nan = NanHandling::left_out) {
  const ScalarField field = test::dense_field<double>(
      {static_cast<int>(samples.size()), 2, 2}, [&](int i, int, int) { return samples[static_cast<std::size_t>(i)]; });
  const ScalarField result = resampled(field, {count, 3, 5}, kernel, nan);
  std::vector<double> row;
  for (int i = 0; i < count; ++i) row.push_back(sample_at(result, {i, 1, 3}));
  return row;
}

TEST(Resample, VoxelSizesDivideBoxAlongFieldAxes) {
  // Rotated and sheared axes of lengths 0.5, 2 and 5.
  ScalarField field = test::random_field<float>({5, 4, 3}, 1, 1);
  field.index_to_world = {{{0.3, 0.4, 0}, {-1.6, 1.2, 0}, {3, 0, 4}}, {100, -20, 7}};
  EXPECT_EQ(resolution_of_voxel_size(field, {0.5, 2, 5}).value(), glm::ivec3(5, 4, 3));
  EXPECT_EQ(resolution_of_voxel_size(field, {0.25, 6, 10.0 / 7}).value(), glm::ivec3(9, 2, 8));
  EXPECT_EQ(resolution_of_voxel_size(field, {3.9, 2.4 - 1e-3, 2.4}).value(), glm::ivec3(2, 4, 5));
  // Both ends stay, and the samples are evenly spaced along the axes.
  const ScalarField finer = resampled(field, resolution_of_voxel_size(field, {0.25, 6, 10.0 / 7}).value());
  for (const glm::ivec3& p : {glm::ivec3(0), glm::ivec3(8, 1, 7), glm::ivec3(3, 0, 5)}) {
    const glm::dvec3 place = field.index_to_world.offset + 0.25 * p.x * glm::dvec3(0.6, 0.8, 0) +
                             6.0 * p.y * glm::dvec3(-0.8, 0.6, 0) + 10.0 / 7 * p.z * glm::dvec3(0.6, 0, 0.8);
    EXPECT_LT(glm::length(finer.index_to_world(p) - place), 1e-12);
  }
  EXPECT_EQ(sample_at(finer, {8, 1, 7}), sample_at(field, {4, 3, 2}));
}

TEST(Resample, RefusesVoxelSizesThatDoNotFit) {
  const ScalarField field = test::random_field<float>({5, 4, 3}, 1, 1);
  for (const double size : {0.0, -1.0, kInfinity, std::nan(""), 1e-12, 4.1}) {
    const auto refused = resolution_of_voxel_size(field, {1, 1, size});
    ASSERT_FALSE(refused) << size;
    EXPECT_EQ(refused.error().code, ErrorCode::usage);
  }
  const auto flat = resolution_of_voxel_size(test::random_field<float>({5, 1, 3}, 1, 1), glm::dvec3(1));
  ASSERT_FALSE(flat);
  EXPECT_EQ(flat.error().code, ErrorCode::input);
}

TEST(Resample, SharesSamplesAtSameResolution) {
  ScalarField field = test::random_field<std::uint16_t>({5, 6, 7}, 1, 60000);
  field.notes = {{NoteId::extra_bytes, "the reader skips bytes"}};
  field.scale = {-2, 1};
  const ScalarField same = resampled(field, {5, 6, 7});
  EXPECT_EQ(dense_samples(same).data, dense_samples(field).data);
  EXPECT_EQ(same.type(), SampleType::u16);
  EXPECT_EQ(same.index_to_world, field.index_to_world);
  EXPECT_EQ(same.index_to_file, Affine());
  EXPECT_TRUE(same.notes.empty());
}

// For every type: a new sample on an old one has its exact bits, also NaN and -0.
TEST(Resample, KeepsExactValuesAtOldSamples) {
  for (const SampleType type : {SampleType::u8, SampleType::i8, SampleType::u16, SampleType::i16, SampleType::u32,
                                SampleType::i32, SampleType::f16, SampleType::f32, SampleType::f64}) {
    visit_sample_type(type, [&]<class T>(std::type_identity<T>) {
      const ScalarField field = test::dense_field<T>({4, 5, 3}, [](int i, int j, int k) -> double {
        if (is_floating_sample<T> && i == 1)
          return j == 1 ? test::kNaN : j == 2 ? -kInfinity : j == 3 ? kInfinity : -0.0;
        if (sizeof(T) == 4 && std::is_integral_v<T>) return 2147483647 - i - 10 * j - 100 * k;
        return i + 7 * j + 20 * k;
      });
      const ScalarField finer = resampled(field, {10, 9, 7});
      const bool is_double = type == SampleType::f64 || type == SampleType::u32 || type == SampleType::i32;
      EXPECT_EQ(finer.type(), is_double ? SampleType::f64 : SampleType::f32);
      for_each_sample({4, 5, 3}, [&](const glm::ivec3& p) {
        EXPECT_EQ(std::bit_cast<std::uint64_t>(sample_at(finer, p * glm::ivec3(3, 2, 3))),
                  std::bit_cast<std::uint64_t>(sample_at(field, p)));
      });
    });
  }
}

// A function linear along each axis, including products, keeps its value at every world position: in a rotated, sheared
// and mirrored frame, with a value scale, on finer and coarser grids, and without common samples.
TEST(Resample, KeepsTrilinearFieldInPlace) {
  const Affine frame{glm::dmat3(-2, 0.3, 0, 0.5, 1, 0.2, 0, -0.4, 0.1), glm::dvec3(5, -3, 1e4)};
  const auto f = [](const glm::dvec3& p) { return 1 + 2 * p.x - p.y + 0.5 * p.x * p.y * p.z - 3 * p.y * p.z; };
  ScalarField field = test::dense_field<double>({9, 8, 5}, [&](int i, int j, int k) { return f({i, j, k}); });
  field.index_to_world = frame;
  field.index_to_file = scaling({2, 2, 2});
  field.scale = {-3, 7};
  for (const glm::ivec3& resolution : {glm::ivec3(17, 31, 6), {2, 2, 2}, {64, 3, 5}, {10, 9, 130}}) {
    const ScalarField other = resampled(field, resolution);
    EXPECT_EQ(other.scale.slope, -3);
    for_each_sample(resolution, [&](const glm::ivec3& p) {
      const glm::dvec3 old = glm::dvec3(p) * glm::dvec3(8, 7, 4) / glm::dvec3(resolution - 1);
      ASSERT_NEAR(sample_at(other, p), f(old), 1e-11);
      ASSERT_NEAR(glm::length(other.index_to_world(p) - frame(old)), 0, 1e-11);
      ASSERT_NEAR(glm::length(other.index_to_file(p) - 2.0 * old), 0, 1e-11);
    });
  }
}

TEST(Resample, FinerGridEqualsInterpolant) {
  const ScalarField field = test::random_field<double>({6, 7, 8}, 5, 1000);
  for (const auto& [kernel, interpolation] :
       {std::pair(kLinear, Interpolation::trilinear), std::pair(ResampleKernel::cubic, Interpolation::tricubic)}) {
    const ScalarField other = resampled(field, {23, 9, 12}, kernel);
    const Interpolant interpolant(field, interpolation);
    Interpolant::Cursor at(interpolant);
    for_each_sample({23, 9, 12}, [&](const glm::ivec3& p) {
      ASSERT_NEAR(sample_at(other, p), at(glm::dvec3(p) * glm::dvec3(5, 6, 7) / glm::dvec3(22, 8, 11)).value, 1e-9);
    });
  }
}

TEST(Resample, CoarserGridEqualsMeanOverStep) {
  const std::vector<double> samples{3, 1, 4, 1, 5, 9, 2, 6, 5, 3, 5, 8, 9};
  // Steps of two: one whole sample and half of each neighbor.
  const std::vector<double> halves = row_of(samples, 7);
  for (std::size_t i = 1; i < 6; ++i) {
    EXPECT_NEAR(halves[i], samples[2 * i - 1] / 4 + samples[2 * i] / 2 + samples[2 * i + 1] / 4, 1e-12);
  }
  EXPECT_EQ(halves.front(), 3);
  EXPECT_EQ(halves.back(), 9);
  // Any step: the new samples share each old one, and the sum stays the same.
  for (const int count : {12, 9, 7, 6, 5, 4}) {
    std::vector<double> spike(61, 0.0);
    spike[29] = 1;
    const double step = 60.0 / (5 * count - 1);
    double sum = 0;
    for (const double value : row_of(spike, 5 * count)) sum += value;
    EXPECT_NEAR(sum * step, 1, 1e-12) << count;
  }
  // Details finer than the new grid vanish, and NaN is left out or spreads.
  std::vector<double> stripes;
  for (int i = 0; i < 65; ++i) stripes.push_back(i % 2 == 0 ? 1 : -1);
  const std::vector<double> flat = row_of(stripes, 17);
  for (std::size_t i = 1; i < 16; ++i) EXPECT_LT(std::abs(flat[i]), 0.01);
  stripes[32] = test::kNaN;
  EXPECT_TRUE(std::isnan(row_of(stripes, 17, kLinear, NanHandling::spread)[8]));
  const std::vector<double> holed = row_of(stripes, 17);
  EXPECT_NEAR(holed[8], -1.0 / 3, 1e-12) << "(1/2 - 1 - 1 + 1/2) of a weight of 3";
  EXPECT_EQ(holed[10], flat[10]);
  for (const double value : row_of(std::vector<double>(50, 0.1), 7)) EXPECT_EQ(value, 0.1);
  // A step hardly longer than a voxel hardly changes anything.
  std::vector<double> spike(101, 0.0);
  spike[5] = 8;
  EXPECT_GT(std::ranges::max(row_of(spike, 100)), 7);
  std::vector<double> line;
  for (int i = 0; i < 50; ++i) line.push_back(i);
  const std::vector<double> moved = row_of(line, 30);
  for (std::size_t i = 0; i < moved.size(); ++i) {
    EXPECT_NEAR(moved[i], static_cast<double>(i) * 49 / 29, 1.0 / 8 / (49.0 / 29) + 1e-12);
  }
}

TEST(Resample, CubicInterpolatesSamplesAndKeepsParabolas) {
  const std::vector<double> samples{3, 1, 4, 1, 5, 9, 2, 6};
  const std::vector<double> finer = row_of(samples, 29, ResampleKernel::cubic);
  for (std::size_t i = 0; i < samples.size(); ++i) EXPECT_EQ(finer[4 * i], samples[i]);
  std::vector<double> parabola;
  for (int i = 0; i < 6; ++i) parabola.push_back(2 * i * i - 7 * i + 1);
  const std::vector<double> values = row_of(parabola, 21, ResampleKernel::cubic);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double x = static_cast<double>(i) / 4;
    EXPECT_NEAR(values[i], 2 * x * x - 7 * x + 1, 1e-12);
  }
  for (const double value : row_of(std::vector<double>(5, 0.1), 33, ResampleKernel::cubic)) EXPECT_EQ(value, 0.1);
  EXPECT_EQ(row_of({1, 2}, 5, ResampleKernel::cubic), (std::vector<double>{1, 1.25, 1.5, 1.75, 2}));
}

TEST(Resample, BSplineSmoothsSamplesAndKeepsLines) {
  const std::vector<double> samples{3, 1, 4, 1, 5, 9, 2, 6};
  const std::vector<double> finer = row_of(samples, 29, ResampleKernel::bspline);
  EXPECT_NEAR(finer.front(), 3, 1e-12);
  EXPECT_NEAR(finer.back(), 6, 1e-12);
  for (std::size_t i = 1; i + 1 < samples.size(); ++i) {
    EXPECT_NEAR(finer[4 * i], (samples[i - 1] + 4 * samples[i] + samples[i + 1]) / 6, 1e-12);
  }
  EXPECT_EQ(row_of(samples, 8, ResampleKernel::bspline)[4], finer[16]) << "also at the resolution of its own";
  const std::vector<double> line = row_of({0, 1, 2, 3, 4}, 41, ResampleKernel::bspline);
  for (std::size_t i = 0; i < line.size(); ++i) EXPECT_NEAR(line[i], static_cast<double>(i) / 10, 1e-12);
  constexpr double kMost = std::numeric_limits<double>::max();
  for (const double value : row_of({-kMost, kMost, kMost, -kMost, kMost}, 50, ResampleKernel::bspline)) {
    EXPECT_TRUE(std::isfinite(value));
  }
}

TEST(Resample, NearestReturnsOldSamples) {
  const std::vector<double> samples{3, 1, 4, 8, 16};
  EXPECT_EQ(row_of(samples, 9, ResampleKernel::nearest), (std::vector<double>{3, 3, 1, 1, 4, 4, 8, 8, 16}));
  EXPECT_EQ(row_of(samples, 13, ResampleKernel::nearest),
            (std::vector<double>{3, 3, 1, 1, 1, 4, 4, 4, 8, 8, 8, 16, 16}));
  EXPECT_EQ(row_of(samples, 4, ResampleKernel::nearest), (std::vector<double>{3, 1, 8, 16})) << "no means";
  const ScalarField ids = test::dense_field<std::int32_t>(
      {5, 5, 5}, [](int i, int j, int k) { return (i + j + k) % 2 == 0 ? 2'000'000'001 : -7; });
  for (const glm::ivec3& resolution : {glm::ivec3(9), glm::ivec3(3, 4, 20)}) {
    const ScalarField other = resampled(ids, resolution, ResampleKernel::nearest);
    EXPECT_EQ(other.type(), SampleType::i32);
    for_each_sample(resolution, [&](const glm::ivec3& p) {
      const double value = sample_at(other, p);
      EXPECT_TRUE(value == 2'000'000'001 || value == -7) << value;
    });
  }
}

TEST(Resample, MajorityReturnsTheValueOfMostVoxels) {
  const auto middle = [](const std::vector<double>& samples, NanHandling nan = NanHandling::left_out) {
    return row_of(samples, 3, ResampleKernel::majority, nan)[1];
  };
  constexpr double kNaN = test::kNaN;
  // Half of the voxels beside the middle one are in its cell.
  EXPECT_EQ(middle({9, 5, 5, 7, 1}), 5);
  EXPECT_EQ(middle({9, 5, 7, 5, 1}), 7) << "as many of both: the nearest";
  EXPECT_EQ(middle({0, 0, 4, 7, 4, 0, 0}), 4);
  EXPECT_EQ(middle({0, 0, 0, 4, 4, 9, 2, 2, 0, 0, 0}), 2) << "as many of both: the least";
  EXPECT_EQ(row_of({1, 2, 2, 2, 2, 2, 3}, 3, ResampleKernel::majority), (std::vector<double>{1, 2, 3}))
      << "the boundary stays";
  EXPECT_EQ(row_of({1, 2}, 4, ResampleKernel::majority), (std::vector<double>{1, 1, 2, 2})) << "finer: the nearest";
  EXPECT_EQ(middle({0, 0, 4, kNaN, 4, 0, 0}), 4);
  EXPECT_EQ(middle({0, 0, 0, 4, 4, 9, kNaN, kNaN, 0, 0, 0}), 4) << "NaN loses a tie";
  EXPECT_TRUE(std::isnan(middle({0, 0, 4, kNaN, 7, 0, 0}))) << "unless it is nearest";
  EXPECT_TRUE(std::isnan(middle({0, 0, kNaN, 4, 4, 0, 0}, NanHandling::spread)));
  // More values than are searched one by one; ids that float cannot hold.
  const ScalarField ids = test::dense_field<std::int32_t>(
      {9, 9, 9}, [](int i, int j, int k) { return 2'000'000'000 + (i + 9 * j + 81 * k) % 61 * (i % 2); });
  const ScalarField coarse = resampled(ids, glm::ivec3(3), ResampleKernel::majority);
  EXPECT_EQ(coarse.type(), SampleType::i32);
  EXPECT_EQ(sample_at(coarse, glm::ivec3(1)), 2'000'000'000);
}

TEST(Resample, KernelsAreLinearBesideNonFiniteSamples) {
  const std::vector<double> samples{1, 2, 5, test::kNaN, 5, 2, 1, 0};
  for (const ResampleKernel kernel : {ResampleKernel::cubic, ResampleKernel::bspline}) {
    for (const NanHandling nan : {NanHandling::left_out, NanHandling::spread}) {
      const std::vector<double> row = row_of(samples, 15, kernel, nan);
      EXPECT_EQ(row[3], 3.5);
      for (std::size_t i = 0; i < row.size(); ++i) {
        EXPECT_EQ(std::isnan(row[i]), nan == NanHandling::spread ? i >= 5 && i <= 7 : i == 6) << i;
      }
      if (nan == NanHandling::left_out) {
        EXPECT_EQ(row[5], 5);
        EXPECT_EQ(row[7], 5);
      }
    }
    EXPECT_EQ(row_of({1, 2, kInfinity, 2, 1, 0}, 11, kernel)[2 * 2], kInfinity);
  }
}

TEST(Resample, IgnoresSamplesOfWeightZero) {
  EXPECT_EQ(row_of({1, kInfinity, 3, 4}, 4)[0], 1);
  const std::vector<double> row = row_of({1, kInfinity, 3, -kInfinity, test::kNaN, 6, 7}, 13);
  EXPECT_EQ(row[0], 1);
  EXPECT_EQ(row[1], kInfinity);
  EXPECT_EQ(row[2], kInfinity);
  EXPECT_EQ(row[3], kInfinity);
  EXPECT_EQ(row[4], 3);
  EXPECT_EQ(row[5], -kInfinity);
  EXPECT_EQ(row[6], -kInfinity);
  EXPECT_EQ(row[7], -kInfinity) << "NaN has half of the weight";
  EXPECT_TRUE(std::isnan(row[8]));
  EXPECT_EQ(row[9], 6);
  EXPECT_EQ(row[10], 6);
  EXPECT_EQ(row[11], 6.5);
  EXPECT_EQ(row[12], 7) << "nothing lies beyond the last sample";
  EXPECT_TRUE(std::isnan(row_of({-kInfinity, kInfinity}, 3)[1])) << "no value lies between both infinities";
}

// Compares with sums over all weights of the three axes, for rows with and without NaN.
TEST(Resample, MeansLeaveNanOut) {
  const glm::ivec3 dims(11, 9, 10);
  const glm::ivec3 coarse(4, 5, 3);
  for (const double share : {0.02, 0.3, 0.6}) {
    std::mt19937 engine(7);
    const ScalarField holed = test::dense_field<double>(dims, [&](int, int, int) {
      const double value = std::uniform_real_distribution<double>(1, 2)(engine);
      return std::uniform_real_distribution<double>(0, 1)(engine) < share ? test::kNaN : value;
    });
    const auto made_of = [&](const auto& value_of) {
      return resampled(test::dense_field<double>(dims,
                                                 [&](int i, int j, int k) {
                                                   return value_of(sample_at(holed, {i, j, k}));
                                                 }),
                       coarse);
    };
    const ScalarField weights = made_of([](double value) { return std::isnan(value) ? 0.0 : 1.0; });
    const ScalarField sums = made_of([](double value) { return std::isnan(value) ? 0.0 : value; });
    const ScalarField found = resampled(holed, coarse);
    int numbers = 0;
    for_each_sample(coarse, [&](const glm::ivec3& p) {
      const double weight = sample_at(weights, p);
      const double value = sample_at(found, p);
      EXPECT_EQ(std::isnan(value), weight < 0.5) << share;
      if (weight < 0.5) return;
      ++numbers;
      EXPECT_NEAR(value, sample_at(sums, p) / weight, 1e-12);
    });
    if (share > 0.1) {
      EXPECT_LT(numbers, coarse.x * coarse.y * coarse.z) << share;
    }
    EXPECT_GT(numbers, 0);
  }
}

TEST(Resample, StaysBetweenNeighborsAtExtremes) {
  constexpr double kMost = std::numeric_limits<double>::max();
  for (const double most : {kMost, 3e38, 5e-324}) {
    double before = -most;
    for (const double value : row_of({-most, most}, 100)) {
      EXPECT_GE(value, before);
      EXPECT_LE(value, most);
      before = value;
    }
    for (const double value : row_of({most, most, most}, 100)) EXPECT_EQ(value, most);
  }
  const ScalarField extreme = test::dense_field<float>({3, 3, 3}, [](int i, int j, int k) {
    return (i + j + k) % 2 == 0 ? std::numeric_limits<float>::max() : -std::numeric_limits<float>::max();
  });
  const ScalarField finer = resampled(extreme, {8, 9, 10});
  for_each_sample({8, 9, 10}, [&](const glm::ivec3& p) { EXPECT_TRUE(std::isfinite(sample_at(finer, p))); });
}

TEST(Resample, SparseEqualsDenseOverStoredBox) {
  const ScalarField dense = test::dense_field<std::int16_t>({32, 24, 40}, [](int i, int j, int k) {
    const bool margin = std::min({i, j, k}) < 2 || i > 29 || j > 21 || k > 37;
    return margin ? -3 : i >= 16 && i < 24 && j < 16 ? 7 : (i * 7 + j * 3 + k * 11) % 100;
  });
  ScalarField sparse = test::sparse_copy<std::int16_t>(dense, -3);
  ASSERT_FALSE(std::get<SparseSamples>(sparse.samples).tiles.empty());
  // Extraction ignores whether a voxel is active, and so does resampling.
  std::get<SparseSamples>(sparse.samples).active_box = {glm::ivec3(5), glm::ivec3(6)};
  const ScalarField own = resampled(sparse, {30, 22, 38});
  ASSERT_EQ(own.notes.size(), 1U);
  EXPECT_NE(own.notes[0].text.find("30 x 22 x 38 samples of f32 (98 KiB)"), std::string::npos) << own.notes[0].text;
  EXPECT_NE(own.notes[0].text.find("(1, 1, 1) .. (30, 22, 38)"), std::string::npos) << own.notes[0].text;
  EXPECT_EQ(own.index_to_file(glm::dvec3(0)), glm::dvec3(1));
  for_each_sample({30, 22, 38}, [&](const glm::ivec3& p) { ASSERT_EQ(sample_at(own, p), sample_at(dense, p + 1)); });

  const ScalarField finer = resampled(sparse, {61, 33, 50});
  const Interpolant interpolant(sparse, Interpolation::trilinear);
  Interpolant::Cursor at(interpolant);
  for_each_sample({61, 33, 50}, [&](const glm::ivec3& p) {
    ASSERT_NEAR(sample_at(finer, p), at(finer.index_to_file(p)).value, 1e-5);
  });
}

TEST(Resample, AcceptsNegativeIndicesTilesAndEmptyField) {
  SparseSamples samples;
  const std::vector<float> ones(512, 1.0F);
  samples.blocks = {{glm::ivec3(-8), ones.data()}};
  samples.tiles = {{glm::ivec3(16, 0, 0), 16, 3.0}};
  samples.background = 0.5;
  ScalarField field;
  field.samples = samples;
  const ScalarField own = resampled(field, {42, 26, 26});
  EXPECT_EQ(own.index_to_world(glm::dvec3(0)), glm::dvec3(-9));
  for_each_sample({42, 26, 26}, [&](const glm::ivec3& p) {
    const glm::ivec3 q = p - 9;
    const auto within = [&](int low, int high) {
      return glm::all(glm::greaterThanEqual(q, glm::ivec3(low))) && glm::all(glm::lessThan(q, glm::ivec3(high)));
    };
    const bool in_tile = q.x >= 16 && q.x < 32 && q.y >= 0 && q.y < 16 && q.z >= 0 && q.z < 16;
    ASSERT_EQ(sample_at(own, p), in_tile ? 3 : within(-8, 0) ? 1 : 0.5);
  });

  field.samples = SparseSamples{};
  const ScalarField nothing = resampled(field, {2, 3, 4});
  for_each_sample({2, 3, 4}, [&](const glm::ivec3& p) { EXPECT_EQ(sample_at(nothing, p), 0); });
}

TEST(Resample, FailsForInvalidSizesAndLowMemory) {
  const ScalarField field = test::dense_field<float>({4, 4, 4}, [](int i, int, int) { return i; });
  EXPECT_EQ(
      resample(field, {4, 1, 4}, field::ResampleKernel::linear, field::NanHandling::left_out, Context()).error().code,
      ErrorCode::usage);
  const ScalarField flat = test::dense_field<float>({4, 4, 1}, [](int i, int, int) { return i; });
  EXPECT_EQ(
      resample(flat, {4, 4, 4}, field::ResampleKernel::linear, field::NanHandling::left_out, Context()).error().code,
      ErrorCode::input);
  const Error large =
      resample(field, {100, 100, 100}, kLinear, NanHandling::left_out, Context(MemoryBudget(4'000'000 - 1))).error();
  EXPECT_EQ(large.code, ErrorCode::out_of_memory);
  EXPECT_EQ(large.hint, Hint(Remedy::raise, Setting::memory_limit));
  EXPECT_TRUE(resample(field, {100, 100, 100}, kLinear, NanHandling::left_out, Context(MemoryBudget(4'000'000))));
  EXPECT_TRUE(resample(field, {4, 4, 4}, kLinear, NanHandling::left_out, Context(MemoryBudget(0))))
      << "nothing is allocated";
  const int most = std::numeric_limits<int>::max();
  EXPECT_EQ(
      resample(field, glm::ivec3(most), kLinear, NanHandling::left_out, Context(MemoryBudget(1ULL << 62))).error().code,
      ErrorCode::out_of_memory);
}

TEST(Resample, DoesNotDependOnThreads) {
  const ScalarField field = test::random_field<float>({20, 30, 10}, 9, 1000);
  std::vector<ScalarField> results;
  for (const std::size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    // Uses means and a kernel.
    results.push_back(resampled(field, {13, 150, 7}, ResampleKernel::cubic));
    EXPECT_EQ(std::memcmp(dense_samples(results[0]).data, dense_samples(results.back()).data,
                          dense_samples(results[0]).count() * sizeof(float)),
              0);
  }
}

TEST(Resample, EndsEarlyWhenCancelled) {
  const ScalarField dense = test::random_field<float>({16, 16, 16}, 3, 1000);
  for (const ScalarField& field : {dense, test::sparse_copy<float>(dense, 0)}) {
    const Context context;
    context.cancel();
    const auto made = resample(field, {40, 40, 40}, kLinear, NanHandling::left_out, context);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, ErrorCode::cancelled);
    EXPECT_EQ(context.progress().done(), 0U);
  }
}

TEST(Resample, ReservesMemoryForSparseBlocks) {
  const ScalarField field = test::row_of_blocks(20, 128);
  const auto made = resample(field, {4, 4, 4}, kLinear, NanHandling::left_out, Context(MemoryBudget(100'000)));
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::out_of_memory);
}

}  // namespace
}  // namespace isoextract::field
