#include "cli/render_options.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/srgb.hpp"
#include "cli/option_group.hpp"
#include "cli/shared_options.hpp"
#include "cli/values.hpp"
#include "cli/vertex_plan.hpp"
#include "render/renderer.hpp"
#include "render/transfer_function.hpp"

namespace isoextract::cli {
namespace {

// RRGGBB as screens have it, as linear light.
std::optional<glm::dvec3> colour_in(std::string_view text) {
  if (text.starts_with('#')) text.remove_prefix(1);
  unsigned rgb = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), rgb, 16);
  if (text.size() != 6 || problem != std::errc() || end != text.data() + text.size()) return std::nullopt;
  const auto channel = [&](unsigned shift) { return linear_of_srgb((rgb >> shift & 0xFFU) / 255.0); };
  return glm::dvec3(channel(16), channel(8), channel(0));
}

Result<glm::dvec4> parse_background(std::string_view text) {
  if (text == "none") return glm::dvec4(0);
  const auto colour = colour_in(text == "black" ? "000000" : text == "white" ? "ffffff" : text);
  if (colour) return glm::dvec4(*colour, 1);
  return fail(ErrorKind::usage, fmt::format("expected none, black, white or a colour as RRGGBB, found '{}'", text));
}

Result<std::vector<glm::dvec3>> parse_colours(std::string_view text) {
  std::vector<glm::dvec3> colours;
  for (std::string_view rest = text;;) {
    const std::size_t comma = rest.find(',');
    const auto colour = colour_in(rest.substr(0, comma));
    if (!colour) return fail(ErrorKind::usage, fmt::format("expected colours as RRGGBB[,RRGGBB...], found '{}'", text));
    colours.push_back(*colour);
    if (comma == std::string_view::npos) return colours;
    rest.remove_prefix(comma + 1);
  }
}

Result<std::array<double, 2>> parse_value_range(std::string_view text) {
  const auto numbers = parse_numbers(text);
  if (numbers && numbers->size() == 2 && (*numbers)[0] < (*numbers)[1]) return std::array{(*numbers)[0], (*numbers)[1]};
  return fail(ErrorKind::usage, fmt::format("expected two values MIN,MAX with MIN below MAX, found '{}'", text));
}

Result<double> parse_field_of_view(std::string_view text) {
  const auto degrees = parse_number(text);
  if (degrees && *degrees >= 1 && *degrees <= 170) return *degrees;
  return fail(ErrorKind::usage, fmt::format("expected degrees from 1 to 170, found '{}'", text));
}

Result<double> parse_samples(std::string_view text) {
  const auto samples = parse_number(text);
  if (samples && *samples >= 1.0 / 64 && *samples <= 64) return *samples;
  return fail(ErrorKind::usage, fmt::format("expected samples a voxel, from 0.015625 to 64, found '{}'", text));
}

Result<double> parse_termination(std::string_view text) {
  const auto share = parse_number(text);
  if (share && *share >= 0 && *share < 1) return *share;
  return fail(ErrorKind::usage, fmt::format("expected 0 or more and below 1, found '{}'", text));
}

void declare_picture(const Group& group, RenderFlags& flags) {
  group.value<std::string>(
      "-o,--output", "FILE", flags.output, parse_text,
      "The picture (default: INPUT.png): .png, or .exr with linear light, depth and normals; - is stdout, as PNG. Of "
      "several pictures a pattern, such as turn_{:04}.png.");
  group.value("--size", "WxH", flags.size, parse_picture_size, "Pixels (default: 960x540).");
  group.value(
      "--camera", "AZ,EL[,DISTANCE]", flags.camera, render::parse_view_angles,
      "Where the camera is, seen from the middle: azimuth and elevation in degrees, and how far (default: 35,20, "
      "so far that all is seen).");
  group.value("--look-at", "X,Y,Z", flags.look_at, parse_vector,
              "What the camera looks at, in the world, in place of the middle of what is drawn first.");
  group.value("--fov", "DEGREES", flags.field_of_view, parse_field_of_view,
              "Vertical field of view (default: 45, that is 0.785 radians).");
  group.choice("--up", flags.up,
               "The axis that points up in the volume, and in the picture (default: z, or y where meshes alone "
               "are drawn that say so). With z the meshes of glTF files, which are y up, are turned to it.");
  std::vector<std::string_view> names;
  for (const auto& word : words_of(render::BuiltInTransfer{})) names.push_back(word.word);
  group.value<std::string>(
      "--tf", "NAME|FILE", flags.transfer, parse_text,
      fmt::format("Transfer function of the volume: {}, none to leave the volume out, or a file with lines of value, "
                  "red, green, blue and opacity (default: {}).",
                  fmt::join(names, ", "), names.front()));
  group.value("--tf-range", "MIN,MAX", flags.transfer_range, parse_value_range,
              "Values that a named transfer function is spread over (default: the least to the greatest sample; of "
              "level sets from 0 inwards).");
  group.value(
      "--unit-length", "L", flags.unit_length, parse_positive,
      "How thick a layer has the opacity that the transfer function says, in the world (default: a hundredth of "
      "the volume's longest side).");
  group.choice("--shading", flags.shading, "Of surfaces: by normals at their vertices, or flat (default: smooth).");
  group.value(
      "--mesh-color", "RRGGBB[,...]", flags.mesh_colours, parse_colours,
      "Colour of meshes whose vertices have none: one for all, or one for each in their order (default: grey).");
  group.value("--background", "COLOUR", flags.background, parse_background,
              "Behind everything: none, black, white or RRGGBB (default: none).");
  group.value("--samples", "N", flags.samples, parse_samples,
              "Samples along a ray, for each voxel's shortest edge (default: 1).");
  group.value("--termination", "T", flags.termination, parse_termination,
              fmt::format("A ray ends where less than this share of light is left, 0 for never (default: {:.6g}).",
                          render::RenderOptions::kTermination));
  group.flag("--no-skipping", flags.no_skipping,
             "Sample space in which the transfer function shows nothing, too. The picture is the same.");
  group.value<std::string>("--json", "FILE", flags.json, parse_text,
                           "Write sizes, times and counts of each picture as JSON.");
}

}  // namespace

void declare_render(CLI::App& app, RenderFlags& flags) {
  declare_input(app, flags.input, "INPUT...",
                "A volume, particles, or the frames of a sequence; and meshes to draw with it, or alone: .glb, .gltf, "
                ".ply, .obj, .stl or .drc");
  declare_particles(app, flags.particles);
  Group(app, "Frames")
      .value<std::string>("--frames", "N|A-BxS,...", flags.frames, parse_text,
                          "Of one input the pictures of a turn around it, N of them; of a sequence which of its frames "
                          "to draw, as in convert (default: all of them).");
  const Group surface(app, "Surface");
  surface.values("--iso", "V", flags.isos, parse_iso,
                 fmt::format("Draw a surface of the volume as well. {}", kIsoText));
  declare_surface(surface, flags.surface);
  const Group vertices(app, "Vertices");
  vertices.value("--color-by", "iso[:MAP][:MIN,MAX]", flags.colour, parse_colour,
                 "Give each --iso a colour by its value; outer ones let inner ones be seen.");
  vertices.value("--opacity", "A[,B...]", flags.opacity, parse_opacity,
                 "Opacity of the surfaces of --iso and of meshes, above 0 and at most 1: one for all, or one for each, "
                 "those of --iso first (default: opaque).");
  declare_picture(Group(app, "Output"), flags);
  const Group run(app, "Run");
  run.choice("--backend", flags.backend,
             "What draws: the processor, a GPU, or a GPU where there is one that is not software (default: auto).");
  declare_device(run, flags.device);
  declare_run(app, flags.run);
}

}  // namespace isoextract::cli
