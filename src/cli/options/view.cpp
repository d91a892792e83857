#include "cli/options/view.hpp"

#include <charconv>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "base/srgb.hpp"

namespace isoextract::cli {
namespace {

// RRGGBB as screens have it, as linear light.
std::optional<glm::dvec3> color_in(std::string_view text) {
  if (text.starts_with('#')) text.remove_prefix(1);
  unsigned rgb = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), rgb, 16);
  if (text.size() != 6 || problem != std::errc() || end != text.data() + text.size()) return std::nullopt;
  const auto channel = [&](unsigned shift) { return srgb_to_linear((rgb >> shift & 0xFFU) / 255.0); };
  return glm::dvec3(channel(16), channel(8), channel(0));
}

}  // namespace

Result<glm::dvec4> parse_background(std::string_view text) {
  if (text == "none") return glm::dvec4(0);
  const auto color = color_in(text == "black" ? "000000" : text == "white" ? "ffffff" : text);
  if (color) return glm::dvec4(*color, 1);
  return fail(ErrorCode::usage, fmt::format("expected none, black, white or a color as RRGGBB, found '{}'", text));
}

Result<std::vector<glm::dvec3>> parse_colors(std::string_view text) {
  std::vector<glm::dvec3> colors;
  for (std::string_view rest = text;;) {
    const std::size_t comma = rest.find(',');
    const auto color = color_in(rest.substr(0, comma));
    if (!color) return fail(ErrorCode::usage, fmt::format("expected colors as RRGGBB[,RRGGBB...], found '{}'", text));
    colors.push_back(*color);
    if (comma == std::string_view::npos) return colors;
    rest.remove_prefix(comma + 1);
  }
}

Result<double> parse_field_of_view(std::string_view text) {
  const auto degrees = parse_number(text);
  if (degrees && *degrees >= 1 && *degrees <= 170) return *degrees;
  return fail(ErrorCode::usage, fmt::format("expected degrees from 1 to 170, found '{}'", text));
}

ViewFlags::ViewFlags(OptionSet* command, const ViewWords& words)
    : OptionSet(command, OptionGroup::output),
      size{command != nullptr ? Place(*this) : Place(),
           "--size",
           "WxH",
           parse_picture_size,
           fmt::format("Size of a picture in pixels {}", words.size),
           About::picture},
      camera{
          command != nullptr ? Place(*this) : Place(),
          "--camera",
          "AZ,EL[,DISTANCE]",
          render::parse_view_angles,
          "Camera of a picture: azimuth, elevation, distance. Degrees around the up axis from the front, degrees "
          "above the ground, distance from the point of --look-at. Default: 35,20, and far enough to see everything.",
          About::picture},
      look_at{command != nullptr ? Place(*this) : Place(),
              "--look-at",
              "X,Y,Z",
              parse_vector,
              fmt::format("Point that the camera of a picture looks at. {} Default: {}. With the distance of --camera "
                          "all frames of a sequence have one camera.",
                          words.space, words.middle),
              About::picture},
      field_of_view{command != nullptr ? Place(*this) : Place(),        "--fov",       "DEGREES", parse_field_of_view,
                    "Vertical field of view in degrees (default: 45).", About::picture},
      background{command != nullptr ? Place(*this) : Place(),
                 words.background_names,
                 "COLOR",
                 parse_background,
                 fmt::format("Background of a picture (default: {}). none, black, white or RRGGBB.", words.background),
                 About::picture} {}

render::ViewAngles ViewFlags::angles() const {
  render::ViewAngles angles = camera.value_or(render::ViewAngles());
  angles.look_at = look_at;
  return angles;
}

double ViewFlags::fovy() const {
  return field_of_view ? *field_of_view * std::numbers::pi / 180 : render::Camera::kDefaultFovy;
}

}  // namespace isoextract::cli
