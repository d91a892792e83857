#include "cli/height_plan.hpp"

#include <array>
#include <string_view>

#include <fmt/format.h>

#include "cli/plan_parts.hpp"

namespace isoextract::cli {
namespace {

struct Refused {
  std::string_view name;
  std::string_view why;
};

// Options that need an isosurface, or the field around a surface.
constexpr std::array kRefused{
    Refused{"--iso", "terrain has no iso value"},
    Refused{"--iso-table", "terrain has no iso value"},
    Refused{"--labels", "terrain has no labels"},
    Refused{"--method", "terrain has one method"},
    Refused{"--inside", "inside is always below the heights"},
    Refused{"--roi", "the region of a volume has three axes; --clip cuts terrain"},
    Refused{"--resolution", "resampling needs a volume"},
    Refused{"--voxel-size", "resampling needs a volume"},
    Refused{"--filter", "filters need a level set"},
    Refused{"--blur", "blurring needs a volume"},
    Refused{"--attribute", "attributes come from volumes"},
    Refused{"--color-by", "attributes come from volumes"},
    Refused{"--error", "the error is that of an isosurface"},
    Refused{"--verify", "the GPU backend makes no terrain"},
    Refused{"--backend", "the GPU backend makes no terrain"},
    Refused{"--particles", "particles are no heights"},
};

}  // namespace

Result<void> take_heights(ConvertFlags& flags) {
  if (!flags.heightfield) {
    if (!flags.base) return {};
    return refuse_usage("--base sets the floor of terrain and needs --heightfield", "give --heightfield");
  }
  for (const Refused& refused : kRefused) {
    const Option* const option = flags.find(refused.name);
    if (option == nullptr || option->texts().empty()) continue;
    return refuse_usage(fmt::format("{} does not work with --heightfield: {}", option->name(), refused.why),
                        fmt::format("leave {} out", option->name()));
  }
  if (flags.normals == convert::Normals::smooth) {
    return refuse_usage("--normals smooth does not work with --heightfield: heights have no gradient along z",
                        "use --normals area or --normals flat");
  }
  const bool is_open = flags.base && !flags.base->height;
  if (is_open && flags.surface.cap) {
    return refuse_usage("--base none leaves the terrain open, and --cap closes cuts of closed surfaces only",
                        "leave one of them out");
  }
  flags.isos = {convert::IsoChoice(0.0)};
  return {};
}

void plan_heights(const ConvertFlags& flags, convert::ConversionJob& job) {
  if (!flags.heightfield) return;
  extract::HeightOptions heights;
  if (flags.base) heights = {.solid = flags.base->height.has_value(), .base = flags.base->height};
  job.surface.heights = heights;
  job.surface.nan = flags.surface.nan.value_or(extract::NanPolicy::hole);
  job.source.read.flat = true;
}

}  // namespace isoextract::cli
