#include "cli/picture_plan.hpp"

#include <fmt/format.h>

#include "cli/field_plan.hpp"
#include "cli/particle_file_plan.hpp"
#include "cli/plan_parts.hpp"

namespace isoextract::cli {

bool writes_picture(const ConvertFlags& flags) {
  if (flags.format) return flags.format->picture;
  return flags.output && extension_of(*flags.output) == fmt::format(".{}", kPictureFormat);
}

Result<std::optional<convert::PictureFileOptions>> plan_picture(const ConvertFlags& flags) {
  if (!writes_picture(flags)) {
    TRY(flags.refuse(About::picture, "{} applies to pictures, but the output is not a picture",
                     "give an output name that ends in .png"));
    return std::nullopt;
  }
  TRY(flags.refuse(About::mesh_file, "{} applies to mesh files, but the output is a picture",
                   "leave {} out, or give the output a name of a mesh format"));
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
      "the camera of each picture {} its own surfaces, so the pictures do not show how the surfaces {}: for one camera "
      "give --camera "
      "AZ,EL,DISTANCE and --look-at X,Y,Z",
      picture.angles.look_at ? "takes its distance from" : "looks at the center of",
      picture.angles.look_at ? "grow" : "move");
}

std::string_view other_extension(const ConvertFlags& flags) {
  if (const auto field = field_format(flags)) return word_of(*field);
  if (const auto particles = particle_file_format(flags)) return word_of(*particles);
  return writes_picture(flags) ? kPictureFormat : std::string_view();
}

}  // namespace isoextract::cli
