#include "cli/height_plan.hpp"

#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "cli/plan_parts.hpp"

namespace isoextract::cli {
namespace {

struct Refused {
  const Option& option;
  std::string_view why;
};

// Returns the options that need an isosurface, or the field around a surface.
std::vector<Refused> refused_options(const ConvertFlags& flags) {
  return {{flags.isos, "terrain has no iso value"},
          {flags.batch.iso_table, "terrain has no iso value"},
          {flags.labels.chosen, "terrain has no labels"},
          {flags.surface.method, "terrain has one method"},
          {flags.input.inside, "inside is always below the heights"},
          {flags.surface.roi, "the region of a volume has three axes; --clip cuts terrain"},
          {flags.surface.resolution, "resampling needs a volume"},
          {flags.surface.voxel_size, "resampling needs a volume"},
          {flags.surface.filters, "filters need a level set"},
          {flags.surface.blurs, "blurring needs a volume"},
          {flags.attributes, "attributes come from volumes"},
          {flags.color, "attributes come from volumes"},
          {flags.error, "the error is that of an isosurface"},
          {flags.verify, "the GPU backend makes no terrain"},
          {flags.backend, "the GPU backend makes no terrain"},
          {flags.particles.method, "particles are no heights"}};
}

}  // namespace

Result<void> take_heights(ConvertFlags& flags) {
  if (!flags.heightfield) {
    if (!flags.base) return {};
    return refuse_usage("--base sets the floor of terrain and needs --heightfield", "give --heightfield");
  }
  for (const auto& [option, why] : refused_options(flags)) {
    if (option.texts().empty()) continue;
    return refuse_usage(fmt::format("{} does not work with --heightfield: {}", option.name(), why),
                        fmt::format("leave {} out", option.name()));
  }
  if (flags.normals == convert::Normals::smooth) {
    return refuse_usage("--normals smooth does not work with --heightfield: heights have no gradient along z",
                        "use --normals area or --normals flat");
  }
  const bool is_open = flags.base && !flags.base->height;
  if (is_open && flags.surface.cap) {
    return refuse_usage("--cap closes the cuts of closed surfaces only, and --base none leaves the terrain open",
                        "leave one of them out");
  }
  flags.isos = {convert::IsoChoice::terrain()};
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
