#include "cli/picture_plan.hpp"

#include <fmt/format.h>

#include "cli/field_plan.hpp"
#include "cli/plan_parts.hpp"

namespace isoextract::cli {

bool writes_picture(const ConvertFlags& flags) {
  if (flags.format) return flags.format->picture;
  return flags.output && extension_of(*flags.output) == fmt::format(".{}", kPictureFormat);
}

Result<std::optional<convert::PictureFileOptions>> plan_picture(const ConvertFlags& flags) {
  if (!writes_picture(flags)) {
    TRY(flags.refuse(About::picture, "{} is about a picture, and none is drawn", "name the output .png"));
    return std::nullopt;
  }
  TRY(flags.refuse(About::mesh_file, "{} is about the file of a mesh, and the output is a picture",
                   "leave {} out, or name the output as a mesh"));
  convert::PictureFileOptions picture;
  if (flags.size) {
    picture.width = flags.size->width;
    picture.height = flags.size->height;
  }
  picture.angles = flags.camera.value_or(picture.angles);
  picture.angles.look_at = flags.look_at;
  return picture;
}

std::string cameras_note(const convert::PictureFileOptions& picture) {
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
