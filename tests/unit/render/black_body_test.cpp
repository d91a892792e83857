#include "render/black_body.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace isoextract::render {
namespace {

// CIE 1931 x and y of a linear sRGB color.
glm::dvec2 chromaticity(const glm::dvec3& rgb) {
  const glm::dvec3 xyz(glm::dot(glm::dvec3(0.4124, 0.3576, 0.1805), rgb),
                       glm::dot(glm::dvec3(0.2126, 0.7152, 0.0722), rgb),
                       glm::dot(glm::dvec3(0.0193, 0.1192, 0.9505), rgb));
  return glm::dvec2(xyz) / (xyz.x + xyz.y + xyz.z);
}

TEST(BlackBody, HasChromaticityOfPlanckianLocus) {
  // The locus by integration of Planck's law with the CIE 1931 2 degree observer (Wyszecki and Stiles, "Color Science",
  // 1982, table 1(3.11)), for temperatures whose colors lie in sRGB.
  struct Row {
    double kelvin;
    glm::dvec2 xy;
  };
  for (const Row& row : {Row{2000, {0.5267, 0.4133}}, Row{2500, {0.4770, 0.4137}}, Row{3000, {0.4369, 0.4041}},
                         Row{4000, {0.3805, 0.3768}}, Row{6500, {0.3135, 0.3237}}, Row{10000, {0.2807, 0.2884}}}) {
    const glm::dvec2 found = chromaticity(black_body_color(row.kelvin));
    EXPECT_NEAR(found.x, row.xy.x, 0.0015) << row.kelvin;
    EXPECT_NEAR(found.y, row.xy.y, 0.0015) << row.kelvin;
  }
}

TEST(BlackBody, HasLuminanceOne) {
  for (const double kelvin : {2000.0, 3000.0, 6500.0, 15000.0}) {
    EXPECT_NEAR(glm::dot(glm::dvec3(0.2126, 0.7152, 0.0722), black_body_color(kelvin)), 1, 1e-3) << kelvin;
  }
  // Colder colors lie outside of sRGB and lose their negative blue.
  EXPECT_EQ(black_body_color(1000).b, 0);
  EXPECT_EQ(black_body_color(300), black_body_color(1000));
}

TEST(BlackBody, GlowsFromRedToOrangeWhite) {
  const glm::dvec3 dim = black_body_light(1000);
  EXPECT_GT(dim.r, 0.02);
  EXPECT_LT(dim.r, 0.06);
  EXPECT_LT(dim.g, 0.02 * dim.r);
  const glm::dvec3 bright = black_body_light(3000);
  EXPECT_GT(bright.r, 1.5);
  EXPECT_GT(bright.g, 0.7);
  EXPECT_GT(bright.b, 0.2);
  EXPECT_LT(bright.b, bright.g);
  double last = 0;
  for (double kelvin = 801; kelvin < 15000; kelvin *= 1.1) {
    const double red = black_body_light(kelvin).r;
    EXPECT_GT(red, last) << kelvin;
    last = red;
  }
  EXPECT_EQ(black_body_light(1e9), black_body_light(15000));
  for (const double dark : {800.0, 300.0, 0.0, -5000.0, std::nan("")}) {
    EXPECT_EQ(black_body_light(dark), glm::dvec3(0)) << dark;
  }
}

TEST(BlackBody, MapsValuesToKelvin) {
  const auto light = [](const TransferFunction& function, double value) {
    return glm::dvec3(function.lookup(function.position(value)));
  };
  const TransferFunction kelvins = emission_function(std::nullopt).value();
  const TransferFunction flames = emission_function(std::array{-1.0, 3.0}).value();
  for (const double kelvin : {1000.0, 1517.0, 2200.0, 3000.0}) {
    const glm::dvec3 expected = black_body_light(kelvin) / kUnitsToWhite;
    EXPECT_NEAR(glm::length(light(kelvins, kelvin) - expected), 0, 3e-3 * glm::length(expected)) << kelvin;
    const double value = -1 + 4 * (kelvin - 800) / 2200;
    EXPECT_NEAR(glm::length(light(flames, value) - expected), 0, 1e-3 * glm::length(expected)) << kelvin;
  }
  EXPECT_EQ(light(flames, 50), light(flames, 3));
  for (const double dark : {-1.0, -2.0, -1e30}) EXPECT_EQ(light(flames, dark), glm::dvec3(0));
  for (const double dark : {800.0, 0.0, -1e30}) {
    EXPECT_EQ(light(kelvins, dark), glm::dvec3(0));
    EXPECT_FALSE(kelvins.is_visible_between(kelvins.position(dark - 50), kelvins.position(dark - 1)));
  }
  EXPECT_TRUE(kelvins.is_visible_between(kelvins.position(0), kelvins.position(1000)));
  EXPECT_FALSE(emission_function(std::array{2.0, 1.0}));
  EXPECT_FALSE(emission_function(std::array{0.0, double{INFINITY}}));
}

}  // namespace
}  // namespace isoextract::render
