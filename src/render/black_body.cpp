#include "render/black_body.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace isoextract::render {

glm::dvec3 black_body_color(double kelvin) {
  // Krystek's range. std::max() with NaN as its second argument returns the first.
  const double t = std::min(std::max(1000.0, kelvin), 15000.0);
  // CIE 1960 u and v.
  const double u =
      (0.860117757 + 1.54118254e-4 * t + 1.28641212e-7 * t * t) / (1 + 8.42420235e-4 * t + 7.08145163e-7 * t * t);
  const double v =
      (0.317398726 + 4.22806245e-5 * t + 4.20481691e-8 * t * t) / (1 - 2.89741816e-5 * t + 1.61456053e-7 * t * t);
  const double sum = 2 * u - 8 * v + 4;
  const double x = 3 * u / sum;
  const double y = 2 * v / sum;
  const glm::dvec3 xyz(x / y, 1, (1 - x - y) / y);
  const glm::dvec3 rgb(glm::dot(glm::dvec3(3.2406, -1.5372, -0.4986), xyz),
                       glm::dot(glm::dvec3(-0.9689, 1.8758, 0.0415), xyz),
                       glm::dot(glm::dvec3(0.0557, -0.2040, 1.0570), xyz));
  return glm::max(rgb, glm::dvec3(0));
}

glm::dvec3 black_body_light(double kelvin) {
  if (!(kelvin > BlackBody::kGlowBegins)) return glm::dvec3(0);
  const double t = std::min(kelvin, BlackBody::kHottest) / BlackBody::kReference;
  constexpr double kBegins = BlackBody::kGlowBegins / BlackBody::kReference;
  constexpr double kLeast = kBegins * kBegins * kBegins * kBegins;
  return (t * t * t * t - kLeast) / (1 - kLeast) * black_body_color(kelvin);
}

Result<TransferFunction> emission_function(const std::optional<std::array<double, 2>>& range) {
  const double last = range ? BlackBody::kReference : BlackBody::kHottest;
  TransferFunction::Table table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(table.size() - 1);
    const glm::dvec3 light =
        black_body_light(BlackBody::kGlowBegins + share * (last - BlackBody::kGlowBegins)) / kUnitsToWhite;
    table[i] = glm::vec4(glm::dvec4(light, std::max({light.r, light.g, light.b})));
  }
  return TransferFunction::of_table(range ? (*range)[0] : BlackBody::kGlowBegins, range ? (*range)[1] : last, table);
}

}  // namespace isoextract::render
