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

convert::PictureFileOptions plan_view(const ViewFlags& flags) {
  convert::PictureFileOptions picture;
  if (flags.size) {
    picture.width = flags.size->width;
    picture.height = flags.size->height;
  }
  picture.angles = flags.angles();
  picture.fovy = flags.fovy();
  picture.background = flags.background.value_or(picture.background);
  return picture;
}

Result<std::optional<convert::PictureFileOptions>> plan_picture(const ConvertFlags& flags) {
  if (!writes_picture(flags)) {
    if (!flags.html && !flags.contact_sheet) {
      TRY(flags.refuse(About::picture, "{} applies to pictures, but the command draws none",
                       "give an output name that ends in .png, or --html or --contact-sheet"));
    }
    return std::nullopt;
  }
  TRY(flags.refuse(About::mesh_file, "{} applies to mesh files, but the output is a picture",
                   "leave {} out, or give the output a name of a mesh format"));
  return plan_view(flags.view);
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

std::string_view non_mesh_extension(const ConvertFlags& flags) {
  if (const auto field = field_format(flags)) return word_of(*field);
  if (const auto particles = particle_file_format(flags)) return word_of(*particles);
  return writes_picture(flags) ? kPictureFormat : std::string_view();
}

}  // namespace isoextract::cli
