// The options of `isoextract render`.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "cli/option.hpp"
#include "cli/options/convert.hpp"
#include "cli/options/input.hpp"
#include "cli/options/run.hpp"
#include "cli/options/surface.hpp"
#include "cli/options/view.hpp"
#include "cli/values.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "render/black_body.hpp"
#include "render/renderer.hpp"
#include "render/scene.hpp"
#include "render/transfer_function.hpp"

namespace isoextract::cli {

// Returns the names of the built-in transfer functions, then "none".
[[nodiscard]] std::vector<std::string> transfer_names();
// Returns the function of a name or an alias; nullopt for other texts.
[[nodiscard]] std::optional<render::BuiltInTransfer> transfer_of(std::string_view name);

// The grid that emits light, and the values that render::emission_function() takes for its range; unset for kelvins.
struct EmissionChoice {
  std::string grid;
  std::optional<std::array<double, 2>> range;

  friend bool operator==(const EmissionChoice&, const EmissionChoice&) = default;
};

// Parses GRID[:MIN,MAX], MIN below MAX. What follows the last colon is a range if it begins like a number and has a
// comma; otherwise the whole text is the name of a grid. Fails with ErrorCode::usage.
[[nodiscard]] Result<EmissionChoice> parse_emission(std::string_view text);

// Parses the value of an option. Fails with ErrorCode::usage.
[[nodiscard]] Result<std::array<double, 2>> parse_value_range(std::string_view text);  // MIN,MAX, MIN below MAX
[[nodiscard]] Result<double> parse_samples(std::string_view text);                     // 1/64 to 64
[[nodiscard]] Result<int> parse_rays_across(std::string_view text);                    // 1 to 4
[[nodiscard]] Result<double> parse_termination(std::string_view text);                 // 0 or more, below 1

// Takes the name of a transfer function, none, or a file.
struct TransferOption : Value<std::string> {
  explicit TransferOption(const Place& place);
  using Value::operator=;

  [[nodiscard]] std::vector<std::string> choices() const override { return transfer_names(); }
};

struct RenderFlags : OptionSet {
  RenderFlags();

  InputFlags input{*this,
                   {"INPUT...", "Volume, particles or frames to draw, and meshes. Formats of meshes: " +
                                    mesh_io::mesh_extensions()}};  // volumes and meshes
  ParticleFlags particles{*this};
  Value<std::string> frames{
      in(OptionGroup::frames), "--frames", "N|A-BxS,...", parse_text,
      "Pictures of a turn, or frames of a sequence. With at most one volume, N draws N pictures while the camera turns "
      "around the scene once. With a sequence, A-BxS,... chooses the frames to draw, as in "
      "convert (default: all frames)."};
  IsoOption isos{in(OptionGroup::surface), "Draw a surface of the volume as well. ", ""};
  SurfaceFlags surface{*this};
  LabelFlags labels{*this, LabelFlags::Taken::names};
  Value<ColorFlag> color{in(OptionGroup::vertices),
                         "--color-by",
                         "iso[:MAP][:MIN,MAX]",
                         parse_color,
                         "Color the surfaces of --iso by iso value. Outer surfaces become transparent.",
                         About::drawn_surface};
  Value<std::vector<double>> opacity{
      in(OptionGroup::vertices), "--opacity", "A[,B...]", parse_opacity,
      "Opacity of surfaces and meshes, above 0, at most 1. One for all, or one for each: "
      "surfaces of --iso or --labels first, then meshes. Default: opaque, but for outer surfaces with --color-by and "
      "meshes whose materials state an opacity."};
  Value<std::string> output{
      in(OptionGroup::output), "-o,--output", "FILE", parse_text,
      "Picture to write (default: INPUT.png). .png, or .exr with linear light, depth and "
      "normals; - is stdout, as PNG. For several pictures FILE is a pattern, such as turn_{:04}.png, or a folder."};
  ViewFlags view{this,
                 {"--background,--background-color", "none", "(default: 960x540).", "In world coordinates.",
                  "the center of what is visible"}};
  Value<convert::UpAxis> up{
      in(OptionGroup::output), "--up",
      "Axis that points up in volume and picture. With z, meshes of glTF files, which are y up, "
      "are turned to z up. Default: y if every input is a mesh that 'isoextract --up y' wrote, else z."};
  TransferOption transfer{in(OptionGroup::output)};
  Value<std::array<double, 2>> transfer_range{
      in(OptionGroup::output),
      "--tf-range",
      "MIN,MAX",
      parse_value_range,
      "Values that a named transfer function covers. Without it the samples decide. Usually the range begins where the "
      "noise of the background ends. It ends at the 99.9th percentile of the samples above its beginning, but is at "
      "most 8 times as long as the distance from there to the mean of these samples. For level sets it has the values "
      "inside, for fields like seismic amplitudes the values far from 0.",
      About::drawn_volume};
  Value<double> unit_length{
      in(OptionGroup::output),
      "--unit-length",
      "L",
      parse_positive,
      "Path length to which the opacities of --tf belong. In world units: a ray that goes this far through one value "
      "has the opacity that --tf gives for it. Default: a hundredth of the volume's longest side.",
      About::drawn_volume};
  Value<EmissionChoice> emission{
      in(OptionGroup::output),
      "--emission",
      "GRID[:MIN,MAX]",
      parse_emission,
      fmt::format(
          "Light from a second grid of the file. Its values are kelvins: nothing glows up to {:g} K, 1000 K is a "
          "dim red, 3000 K a bright orange-white. With MIN,MAX, the values from MIN to MAX stand for {:g} to {:g} "
          "K, for grids like flames:0,1. Density of --grid in front of the light dims it; where there is none, "
          "the grid glows all the same.",
          render::BlackBody::kGlowBegins, render::BlackBody::kGlowBegins, render::BlackBody::kReference),
      About::drawn_volume};
  Value<render::Shading> shading{in(OptionGroup::output), "--shading",
                                 "Shading of surfaces (default: smooth). smooth interpolates the vertex normals; flat "
                                 "takes one normal per triangle, and is the default with --method voxels."};
  Value<std::vector<glm::dvec3>> mesh_colors{in(OptionGroup::output), "--mesh-color", "RRGGBB[,...]", parse_colors,
                                             "Color of meshes without vertex colors. One for all, or one for each in "
                                             "order. Default: their materials, else gray."};
  Value<double> samples{in(OptionGroup::output),
                        "--samples",
                        "N",
                        parse_samples,
                        "Samples per shortest voxel edge on a ray (default: 1).",
                        About::drawn_volume};
  Value<int> antialias{in(OptionGroup::output), "--antialias", "N", parse_rays_across,
                       "Rays per pixel along each axis, 1 to 4. Default: 2 with surfaces or meshes, whose edges it "
                       "smooths; 1 for a volume alone. The time grows with N x N."};
  Value<double> termination{in(OptionGroup::output), "--termination", "T", parse_termination,
                            fmt::format("Remaining transmittance below which a ray ends. Default: {:.6g}.",
                                        render::RenderOptions::kTermination)};
  Flag no_skipping{in(OptionGroup::output), "--no-skipping",
                   "Sample empty space, too. The picture is the same; for measurements of speed.", About::drawn_volume};
  Value<std::string> json{in(OptionGroup::output), "--json", "FILE", parse_text,
                          "Write sizes, times and counts as JSON."};
  Value<convert::Backend> backend{
      in(OptionGroup::run), "--backend",
      "Backend that draws (default: auto). cpu, gpu, or auto: a GPU if there is one that is not a software renderer."};
  DeviceFlags device{*this};
  RunFlags run{*this};
};

}  // namespace isoextract::cli
