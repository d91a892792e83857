#include "base/attribute_kind.hpp"

#include <gtest/gtest.h>

namespace isoextract {
namespace {

TEST(AttributeKind, FindsKindByName) {
  for (const char* name : {"v", "V", "u", "f", "vel", "velocity", "Velocity", "vel_old", "force", "forces", "accel",
                           "wind_velocity", "displacement", "momenta"}) {
    EXPECT_EQ(kind_by_name(name), AttributeKind::vector) << name;
  }
  for (const char* name : {"N", "n", "normal", "Normals"}) EXPECT_EQ(kind_by_name(name), AttributeKind::normal) << name;
  for (const char* name : {"Cd", "Cs", "color", "colour", "Color_0", "rgb", "albedo"}) {
    EXPECT_EQ(kind_by_name(name), AttributeKind::color) << name;
  }
  for (const char* name : {"P", "p", "position", "rest", "Pref", "x y z"}) {
    EXPECT_EQ(kind_by_name(name), AttributeKind::point) << name;
  }
  for (const char* name :
       {"", "w", "vorticity", "angular_velocity", "dir", "heat", "volume", "pressure", "uv", "fog"}) {
    EXPECT_EQ(kind_by_name(name), std::nullopt) << name;
  }
}

}  // namespace
}  // namespace isoextract
