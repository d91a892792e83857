// Extraction reports whether the surface meets the data boundary (meets_boundary). These tests compare that with the
// mesh. A surface that is always closed never meets it.
#include <algorithm>
#include <map>

#include <gtest/gtest.h>

#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

constexpr glm::ivec3 kDims(72, 24, 16);
const field::IndexBox kAll{glm::ivec3(0), kDims - 1};

class DataBoundary : public testing::TestWithParam<Method> {
 protected:
  [[nodiscard]] static ExtractOptions at(double iso) { return test::options_of(GetParam(), iso); }
};
INSTANTIATE_TEST_SUITE_P(Methods, DataBoundary, testing::ValuesIn(test::all_methods()), test::method_name);

class DataBoundaryHoles : public DataBoundary {};
INSTANTIATE_TEST_SUITE_P(Methods, DataBoundaryHoles,
                         testing::ValuesIn(test::methods_without(&MethodTraits::always_closed)), test::method_name);

// Returns a field that is inside in a ball, or outside of it if `turned`.
field::ScalarField ball(const glm::dvec3& center, double radius, bool turned) {
  return test::dense_field<float>(kDims, [&](int i, int j, int k) {
    const double value = radius - glm::length(glm::dvec3(i, j, k) - center);
    return turned ? -value : value;
  });
}

// Returns whether an edge with one triangle lies in a face of the box.
bool is_open_at(const mesh::Mesh& mesh, const field::IndexBox& box) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int c = 0; c < 3; ++c) ++edges[std::minmax(t[c], t[(c + 1) % 3])];
  }
  return std::ranges::any_of(edges, [&](const auto& edge) {
    const glm::dvec3 a = mesh.position(edge.first.first);
    const glm::dvec3 b = mesh.position(edge.first.second);
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {box.min[axis], box.max[axis]}) {
        if (edge.second == 1 && a[axis] == side && b[axis] == side) return true;
      }
    }
    return false;
  });
}

// Compares the report with the open and the capped mesh. Returns whether the surface meets the boundary.
bool expect_reported(const field::ScalarField& field, ExtractOptions options, const field::IndexBox& box) {
  options.cap = false;
  const Extraction open = test::extract(field, options);
  EXPECT_EQ(open.stats.meets_boundary, is_open_at(open.mesh, box));
  options.cap = true;
  const Extraction capped = test::extract(field, options);
  EXPECT_EQ(capped.stats.meets_boundary, open.stats.meets_boundary);
  EXPECT_EQ(capped.stats.inside_at_boundary, open.stats.inside_at_boundary);
  EXPECT_EQ(capped.stats.inside_at_boundary, capped.mesh.triangles.size() > open.mesh.triangles.size());
  return open.stats.meets_boundary;
}

TEST_P(DataBoundary, ReportsContactOfBalls) {
  int met = 0;
  int missed = 0;
  for (const bool turned : {false, true}) {
    // Within the data, at a face, an edge, a corner, and next to the ends of words and blocks.
    for (const glm::dvec3 center :
         {glm::dvec3(36, 12, 8), glm::dvec3(0, 12, 8), glm::dvec3(71, 12, 8), glm::dvec3(36, 0, 0),
          glm::dvec3(71, 23, 15), glm::dvec3(63.5, 12, 8), glm::dvec3(36, 20.7, 8)}) {
      for (const double radius : {2.2, 5.0}) {
        SCOPED_TRACE(testing::Message() << center.x << ", " << center.y << ", " << center.z << " radius " << radius);
        const field::ScalarField field = ball(center, radius, turned);
        (expect_reported(field, at(0), kAll) ? met : missed) += 1;
        // Background on the outer side of the ball surrounds the data and closes the surface; a region opens it again.
        const field::ScalarField sparse = test::sparse_copy<float>(field, turned ? 100 : -100);
        EXPECT_FALSE(test::extract(sparse, at(0)).stats.meets_boundary);
        EXPECT_FALSE(test::extract(sparse, at(0)).stats.inside_at_boundary);
        ExtractOptions options = at(0);
        for (const field::IndexBox& region : {kAll, field::IndexBox{{3, 2, 1}, {69, 21, 14}}}) {
          options.region = region;
          expect_reported(field, options, region);
          expect_reported(sparse, options, region);
        }
      }
    }
  }
  if (test::traits_of(GetParam()).always_closed) {
    EXPECT_EQ(met, 0);
  } else {
    EXPECT_GT(met, 5);
  }
  EXPECT_GT(missed, 5);
}

TEST_P(DataBoundary, ReportsContactOfOneSample) {
  for (const glm::ivec3 at_one :
       {glm::ivec3(0, 5, 5), glm::ivec3(71, 23, 5), glm::ivec3(70, 5, 5), glm::ivec3(5, 0, 14)}) {
    for (const double sign : {1.0, -1.0}) {
      const field::ScalarField field = test::dense_field<float>(
          kDims, [&](int i, int j, int k) { return glm::ivec3(i, j, k) == at_one ? sign : -sign; });
      EXPECT_EQ(expect_reported(field, at(0), kAll), at_one.x != 70 && !test::traits_of(GetParam()).always_closed);
    }
  }
}

// If every crossed cell at the boundary is left out, the surface ends at the holes and does not meet the boundary.
TEST_P(DataBoundaryHoles, DoNotCountAsContact) {
  ExtractOptions options = at(0);
  options.nan = NanPolicy::hole;
  int met = 0;
  for (const int first : {0, 36, 72}) {  // from this x on, the samples at y = 1 are missing
    const field::ScalarField whole = ball({36, 0, 8}, 5, false);
    const auto& samples = std::get<field::DenseSamples>(whole.samples);
    const auto* values = static_cast<const float*>(samples.data);
    const field::ScalarField field = test::dense_field<float>(kDims, [&](int i, int j, int k) {
      return j == 1 && i >= first ? test::kNaN : static_cast<double>(values[i + kDims.x * (j + kDims.y * k)]);
    });
    const Extraction result = test::extract(field, options);
    EXPECT_EQ(result.stats.meets_boundary, is_open_at(result.mesh, kAll)) << first;
    met += result.stats.meets_boundary ? 1 : 0;
    ExtractOptions within = options;
    within.region = kAll;
    EXPECT_EQ(test::extract(test::sparse_copy<float>(field, -100), within).stats.meets_boundary,
              result.stats.meets_boundary);
  }
  EXPECT_EQ(met, 2);
}

}  // namespace
}  // namespace isoextract::extract
