#include "cli/picture_plan.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "cli/field_plan.hpp"
#include "cli/plan_parts.hpp"

namespace isoextract::cli {

bool writes_picture(const ConvertFlags& flags) {
  if (flags.format) return flags.format->picture;
  return flags.output && extension_of(*flags.output) == fmt::format(".{}", kPictureFormat);
}

Result<std::optional<convert::PictureFileOptions>> plan_picture(const ConvertFlags& flags) {
  using Given = std::pair<bool, std::string_view>;
  const auto first_given = [](const auto& options) {
    const auto* const found = std::ranges::find(options, true, &Given::first);
    return found == options.end() ? std::string_view() : found->second;
  };
  if (!writes_picture(flags)) {
    const std::array<Given, 3> of_pictures{{{flags.size.has_value(), "--size"},
                                            {flags.camera.has_value(), "--camera"},
                                            {flags.look_at.has_value(), "--look-at"}}};
    const std::string_view option = first_given(of_pictures);
    if (option.empty()) return std::nullopt;
    return refuse_usage(fmt::format("{} is about a picture, and none is drawn", option), "name the output .png");
  }
  const std::array<Given, 7> of_files{{{flags.ascii, "--ascii"},
                                       {flags.placement.up_out.has_value(), "--up-out"},
                                       {flags.draco.has_value(), "--draco"},
                                       {flags.quantize, "--quantize"},
                                       {flags.meshopt, "--meshopt"},
                                       {flags.optimize_order, "--optimize-order"},
                                       {flags.batch.animate, "--animate"}}};
  if (const std::string_view option = first_given(of_files); !option.empty()) {
    return refuse_usage(fmt::format("{} is about the file of a mesh, and the output is a picture", option),
                        fmt::format("leave {} out, or name the output as a mesh", option));
  }
  convert::PictureFileOptions picture;
  if (flags.size) {
    picture.width = flags.size->width;
    picture.height = flags.size->height;
  }
  picture.angles = flags.camera.value_or(picture.angles);
  picture.angles.look_at = flags.look_at;
  return picture;
}

std::string note_of_cameras(const convert::PictureFileOptions& picture) {
  if (picture.angles.is_fixed()) return {};
  return fmt::format(
      "each picture {} its own surfaces, so it does not show how they {}: for one camera give --camera "
      "AZ,EL,DISTANCE and --look-at X,Y,Z",
      picture.angles.look_at ? "is taken from as far as needs" : "looks at the middle of",
      picture.angles.look_at ? "grow" : "move");
}

std::string_view other_extension(const ConvertFlags& flags) {
  if (writes_field(flags)) return kFieldFormat;
  return writes_picture(flags) ? kPictureFormat : std::string_view();
}

}  // namespace isoextract::cli
