// The light of hot gas: colors of black bodies, and functions that turn the values of a grid into emitted light.
//
// The chromaticity of a black body is the rational approximation of the Planckian locus of Krystek (Color Research &
// Application 10, 1985, pp. 38-40), which states it for 1000 to 15,000 K; kelvins beyond have the chromaticity of the
// nearest end. The color is that chromaticity in linear sRGB (IEC 61966-2-1) with the luminance 1; negative channels,
// outside of the gamut, are 0.
//
// The energy follows the law of Stefan and Boltzmann, minus that of a body at kGlowBegins: the Draper point, 798 K,
// rounded. Below it bodies do not visibly glow. With t = T / kReference and g = kGlowBegins / kReference:
//   energy(T) = (t^4 - g^4) / (1 - g^4), and 0 for T <= kGlowBegins.
// So 3000 K has the energy 1, 2000 K 0.19, 1500 K 0.058, and 1000 K 0.0073. A camera would see a still steeper rise;
// the fourth power is what programs for effects use, because then the cool parts of a flame remain visible.
#pragma once

#include <array>
#include <optional>

#include <glm/glm.hpp>

#include "base/error.hpp"
#include "render/transfer_function.hpp"

namespace isoextract::render {

// Temperatures in kelvin.
struct BlackBody {
  static constexpr double kGlowBegins = 800;
  static constexpr double kReference = 3000;  // has the energy 1
  static constexpr double kHottest = 15000;   // hotter bodies emit as one of this temperature
};

// The path length, in units of Volume::unit_length, over which gas of BlackBody::kReference reaches the luminance 1,
// the white of a picture.
inline constexpr double kUnitsToWhite = 10;

// Returns the linear color of luminance 1 (before negative channels became 0), for any number of kelvins.
[[nodiscard]] glm::dvec3 black_body_color(double kelvin);

// Returns color times energy; 0 for NaN.
[[nodiscard]] glm::dvec3 black_body_light(double kelvin);

// Returns the function from values to emitted light (Volume::emission). Without a range, values are kelvins. With one,
// its first value is BlackBody::kGlowBegins and its last BlackBody::kReference, the values between are linear between
// these, and values beyond are like the nearest end; the first and all lower values emit nothing. Fails with
// ErrorCode::usage if the range is not finite or not in ascending order.
[[nodiscard]] Result<TransferFunction> emission_function(const std::optional<std::array<double, 2>>& range);

}  // namespace isoextract::render
