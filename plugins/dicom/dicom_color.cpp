#include <algorithm>
#include <cmath>

#include "dicom_parts.hpp"

namespace isoextract_dicom {
namespace {

// CIE 15: the inverse of L*a*b*'s function.
double inverse_lab(double t) {
  constexpr double kDelta = 6.0 / 29.0;
  return t > kDelta ? t * t * t : 3 * kDelta * kDelta * (t - 4.0 / 29.0);
}

// IEC 61966-2-1.
double encode_srgb(double linear) {
  const double v = std::clamp(linear, 0.0, 1.0);
  return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

}  // namespace

// Encoding: DICOM PS3.3, C.10.7.1.1. White is D65, as DCMTK, dcmqi, dcmjs and 3D Slicer write these values; the
// standard refers to ICC's connection space, whose white is D50.
std::array<double, 3> srgb_of_dicom_lab(const std::array<double, 3>& encoded) {
  const double l = encoded[0] / 65535 * 100;
  const double a = encoded[1] / 65535 * 255 - 128;
  const double b = encoded[2] / 65535 * 255 - 128;
  const double fy = (l + 16) / 116;
  const double x = 0.950456 * inverse_lab(fy + a / 500);
  const double y = inverse_lab(fy);
  const double z = 1.088754 * inverse_lab(fy - b / 200);
  return {encode_srgb(3.2404542 * x - 1.5371385 * y - 0.4985314 * z),
          encode_srgb(-0.9692660 * x + 1.8760108 * y + 0.0415560 * z),
          encode_srgb(0.0556434 * x - 0.2040259 * y + 1.0572252 * z)};
}

}  // namespace isoextract_dicom
