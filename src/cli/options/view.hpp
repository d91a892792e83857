// The options of a view: the camera and the picture, the same for every command that draws.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "base/error.hpp"
#include "cli/option.hpp"
#include "cli/values.hpp"
#include "render/camera.hpp"

namespace isoextract::cli {

// Parses the value of an option. Fails with ErrorCode::usage. Colors are sRGB in the text, with or without '#', and
// linear light in the result.
[[nodiscard]] Result<glm::dvec4> parse_background(std::string_view text);  // none (alpha 0), black, white, RRGGBB
[[nodiscard]] Result<std::vector<glm::dvec3>> parse_colors(std::string_view text);  // RRGGBB[,RRGGBB...]
[[nodiscard]] Result<double> parse_field_of_view(std::string_view text);            // 1 to 170 degrees

// Words of the help that differ from command to command.
struct ViewWords {
  std::string_view background_names;  // of the option, the long name last
  std::string_view background;        // the default
  std::string_view size;              // the default and more, after "Size of a picture in pixels"
  std::string_view space;             // of --look-at: "In world coordinates."
  std::string_view middle;            // the default of --look-at
};

struct ViewFlags : OptionSet {
  // Without `command`, the options belong to no command and get no values.
  ViewFlags(OptionSet* command, const ViewWords& words);

  Value<render::PictureSize> size;
  Value<render::ViewAngles> camera;
  Value<glm::dvec3> look_at;
  Value<double> field_of_view;  // degrees
  Value<glm::dvec4> background;

  // Returns the angles of --camera with the point of --look-at.
  [[nodiscard]] render::ViewAngles angles() const;
  // Returns the vertical field of view in radians.
  [[nodiscard]] double fovy() const;
};

}  // namespace isoextract::cli
