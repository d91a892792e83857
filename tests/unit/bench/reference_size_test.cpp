// Areas and volumes of analytic surfaces by integration, against closed forms.
#include "bench/detail/reference_size.hpp"

#include <optional>

#include <gtest/gtest.h>

#include "field/demo_field.hpp"

namespace isoextract::bench {
namespace {

TEST(ReferenceSize, ColumnsMatchClosedForm) {
  // Fields with closed forms, whose size function is removed.
  for (const char* name : {"sphere", "torus"}) {
    field::AnalyticField field = *field::find_analytic_field(name);
    const ReferenceSize exact = find_reference_size(field, 0.03);
    EXPECT_TRUE(exact.closed_form);
    field.size = [](double) -> std::optional<field::SurfaceSize> { return std::nullopt; };
    const ReferenceSize columns = find_reference_size(field, 0.03);
    EXPECT_FALSE(columns.closed_form);
    EXPECT_NEAR(columns.size.area / exact.size.area, 1, 1e-6) << name;
    EXPECT_NEAR(columns.size.volume / exact.size.volume, 1, 1e-6) << name;
    EXPECT_LT(columns.uncertainty.area / exact.size.area, 1e-5);
  }
  // Clipped by the cube; by symmetry half of it is inside.
  const ReferenceSize gyroid = find_reference_size(*field::find_analytic_field("gyroid"), 0);
  EXPECT_NEAR(gyroid.size.volume, 4, 1e-6);
  EXPECT_NEAR(gyroid.size.area, 3.0915 * 16, 0.01) << "64 cells of side 1/2; 3.0915 a^2 for the level surface";
  const ReferenceSize signal = find_reference_size(*field::find_analytic_field("marschner-lobb"), 0.5);
  EXPECT_LT(signal.uncertainty.area / signal.size.area, 1e-4);
}

}  // namespace
}  // namespace isoextract::bench
