// The options of `isoextract render`.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "cli/option.hpp"
#include "cli/options/convert.hpp"
#include "cli/options/input.hpp"
#include "cli/options/run.hpp"
#include "cli/options/surface.hpp"
#include "cli/values.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "render/camera.hpp"
#include "render/renderer.hpp"
#include "render/scene.hpp"
#include "render/transfer_function.hpp"

namespace isoextract::cli {

// "grey, fire"
[[nodiscard]] std::string transfer_list();

[[nodiscard]] Result<glm::dvec4> parse_background(std::string_view text);              // none, black, white, RRGGBB
[[nodiscard]] Result<std::vector<glm::dvec3>> parse_colours(std::string_view text);    // RRGGBB[,RRGGBB...]
[[nodiscard]] Result<std::array<double, 2>> parse_value_range(std::string_view text);  // MIN,MAX
[[nodiscard]] Result<double> parse_field_of_view(std::string_view text);               // 1 to 170 degrees
[[nodiscard]] Result<double> parse_samples(std::string_view text);                     // 1/64 to 64
[[nodiscard]] Result<double> parse_termination(std::string_view text);                 // 0 or more, below 1

struct RenderFlags : OptionSet {
  RenderFlags();

  InputFlags input{
      *this,
      {"INPUT...", "A volume, particles, or the frames of a sequence; and meshes to draw with it, or alone: " +
                       mesh_io::mesh_extensions()}};  // volumes and meshes
  ParticleFlags particles{*this};
  Value<std::string> frames{in(OptionGroup::frames), "--frames", "N|A-BxS,...", parse_text,
                            "Of one input the pictures of a turn around it, N of them; of a sequence which of its "
                            "frames to draw, as in convert (default: all of them)."};
  IsoOption isos{in(OptionGroup::surface), "Draw a surface of the volume as well. ", ""};
  SurfaceFlags surface{*this};
  Value<ColourFlag> colour{in(OptionGroup::vertices),
                           "--color-by",
                           "iso[:MAP][:MIN,MAX]",
                           parse_colour,
                           "Give each --iso a colour by its value; outer ones let inner ones be seen.",
                           About::drawn_surface};
  Value<std::vector<double>> opacity{
      in(OptionGroup::vertices), "--opacity", "A[,B...]", parse_opacity,
      "Opacity of the surfaces of --iso and of meshes, above 0 and at most 1: one for all, or one for each, "
      "those of --iso first (default: opaque)."};
  Value<std::string> output{
      in(OptionGroup::output), "-o,--output", "FILE", parse_text,
      "The picture (default: INPUT.png): .png, or .exr with linear light, depth and normals; - is stdout, as PNG. Of "
      "several pictures a pattern, such as turn_{:04}.png."};
  Value<render::PictureSize> size{in(OptionGroup::output), "--size", "WxH", parse_picture_size,
                                  "Pixels (default: 960x540)."};
  Value<render::ViewAngles> camera{
      in(OptionGroup::output), "--camera", "AZ,EL[,DISTANCE]", render::parse_view_angles,
      "Where the camera is, seen from the middle: azimuth and elevation in degrees, and how far (default: 35,20, "
      "so far that all is seen)."};
  Value<glm::dvec3> look_at{in(OptionGroup::output), "--look-at", "X,Y,Z", parse_vector,
                            "What the camera looks at, in the world, in place of the middle of what is drawn first."};
  Value<double> field_of_view{in(OptionGroup::output), "--fov", "DEGREES", parse_field_of_view,
                              "Vertical field of view (default: 45, that is 0.785 radians)."};
  Value<convert::UpAxis> up{
      in(OptionGroup::output), "--up",
      "The axis that points up in the volume, and in the picture (default: z, or y where meshes alone "
      "are drawn that say so). With z the meshes of glTF files, which are y up, are turned to it."};
  Value<std::string> transfer{
      in(OptionGroup::output), "--tf", "NAME|FILE", parse_text,
      fmt::format("Transfer function of the volume: {}, none to leave the volume out, or a file with lines of value, "
                  "red, green, blue and opacity (default: {}).",
                  transfer_list(), word_of(render::BuiltInTransfer{}))};
  Value<std::array<double, 2>> transfer_range{
      in(OptionGroup::output),
      "--tf-range",
      "MIN,MAX",
      parse_value_range,
      "Values that a named transfer function is spread over (default: the least to the greatest sample; of "
      "level sets from 0 inwards).",
      About::drawn_volume};
  Value<double> unit_length{
      in(OptionGroup::output),
      "--unit-length",
      "L",
      parse_positive,
      "How thick a layer has the opacity that the transfer function says, in the world (default: a hundredth of "
      "the volume's longest side).",
      About::drawn_volume};
  Value<render::Shading> shading{in(OptionGroup::output), "--shading",
                                 "Of surfaces: by normals at their vertices, or flat (default: smooth)."};
  Value<std::vector<glm::dvec3>> mesh_colours{
      in(OptionGroup::output), "--mesh-color", "RRGGBB[,...]", parse_colours,
      "Colour of meshes whose vertices have none: one for all, or one for each in their order (default: grey)."};
  Value<glm::dvec4> background{in(OptionGroup::output), "--background", "COLOUR", parse_background,
                               "Behind everything: none, black, white or RRGGBB (default: none)."};
  Value<double> samples{in(OptionGroup::output), "--samples", "N", parse_samples,
                        "Samples along a ray, for each voxel's shortest edge (default: 1)."};
  Value<double> termination{
      in(OptionGroup::output), "--termination", "T", parse_termination,
      fmt::format("A ray ends where less than this share of light is left, 0 for never (default: {:.6g}).",
                  render::RenderOptions::kTermination)};
  Flag no_skipping{in(OptionGroup::output), "--no-skipping",
                   "Sample space in which the transfer function shows nothing, too. The picture is the same."};
  Value<std::string> json{in(OptionGroup::output), "--json", "FILE", parse_text,
                          "Write sizes, times and counts of each picture as JSON."};
  Value<convert::Backend> backend{
      in(OptionGroup::run), "--backend",
      "What draws: the processor, a GPU, or a GPU where there is one that is not software (default: auto)."};
  DeviceFlags device{*this};
  RunFlags run{*this};
};

}  // namespace isoextract::cli
