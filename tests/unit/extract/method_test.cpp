// Options that the traits of a method rule out are refused, and no others.
#include "extract/method.hpp"

#include <gtest/gtest.h>

#include "field/demo_field.hpp"
#include "support/methods.hpp"

namespace isoextract::extract {
namespace {

TEST(MethodLists, FollowMethodTable) {
  EXPECT_EQ(test::all_methods().size(), kMethods.size());
  for (const auto trait :
       {&MethodTraits::vertices_on_edges, &MethodTraits::axis_edges_only, &MethodTraits::follows_interpolant,
        &MethodTraits::gradient_normals, &MethodTraits::always_closed}) {
    const std::vector<Method> with = test::methods_with(trait);
    const std::vector<Method> without = test::methods_without(trait);
    EXPECT_FALSE(with.empty()) << "a suite without a method checks nothing";
    EXPECT_FALSE(without.empty());
    EXPECT_EQ(with.size() + without.size(), kMethods.size());
    for (const Method method : with) EXPECT_TRUE(test::traits_of(method).*trait);
  }
  EXPECT_EQ(test::cell_methods(), (std::vector{Method::mc, Method::mt}));
}

class OptionsOfMethods : public testing::TestWithParam<Method> {
 protected:
  static void expect_taken(const ExtractOptions& options, bool taken) {
    const field::ScalarField field = field::make_demo_field("demo:sphere?size=8", Context()).value();
    const auto result = make_cpu_extractor()->extract(field, options, Context());
    EXPECT_EQ(result.has_value(), taken);
    if (result) {
      EXPECT_FALSE(result->mesh.triangles.empty());
    } else {
      EXPECT_EQ(result.error().code, ErrorCode::usage);
      EXPECT_EQ(result.error().message.find(method_info(options.method).title), 0U) << result.error().message;
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Methods, OptionsOfMethods, testing::ValuesIn(test::all_methods()), test::method_name);

TEST_P(OptionsOfMethods, AreAcceptedIfTraitsAllow) {
  const MethodTraits& traits = test::traits_of(GetParam());
  const ExtractOptions plain = test::options_of(GetParam(), 0);
  expect_taken(plain, true);
  ExtractOptions options = plain;
  options.edge_keys = true;
  expect_taken(options, traits.vertices_on_edges);
  options = plain;
  options.smooth_normals = true;
  expect_taken(options, traits.gradient_normals);
  options = plain;
  options.nan = NanPolicy::hole;
  expect_taken(options, !traits.always_closed);
}

}  // namespace
}  // namespace isoextract::extract
