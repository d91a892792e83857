#include "cli/simulate_plan.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "batch/output_names.hpp"
#include "batch/output_template.hpp"
#include "cli/output_folders.hpp"
#include "cli/plan_parts.hpp"
#include "field/demo_field.hpp"

namespace isoextract::cli {
namespace {

namespace fs = std::filesystem;

// Returns whether the name is that of a sequence, and refuses every invalid name.
Result<bool> names_sequence(const std::string& output, const SequenceKind& kind) {
  if (is_folder(output)) return true;
  const auto name = TRY(batch::OutputTemplate::parse(output));
  if (name.uses(batch::OutputWord::iso)) {
    return refuse_usage(fmt::format("-o {}: a simulation has no iso value", output), "leave {iso} out");
  }
  if (name.uses(batch::OutputWord::label) || name.uses(batch::OutputWord::name)) {
    return refuse_usage(fmt::format("-o {}: a simulation has no labels", output), "leave {label} and {name} out");
  }
  if (name.uses(batch::OutputWord::piece)) {
    return refuse_usage(fmt::format("-o {}: a simulation has no bodies", output), "leave {piece} out");
  }
  if (name.uses(batch::OutputWord::grid) && kind.grids.front().empty()) {
    return refuse_usage(fmt::format("-o {}: one file holds all grids", output), "leave {grid} out");
  }
  if (kind.grids.size() > 1 && !name.uses(batch::OutputWord::grid)) {
    return refuse_usage(fmt::format("-o {}: {} go to separate files, so the file name needs {{grid}}", output,
                                    fmt::join(kind.grids, " and ")),
                        fmt::format("for example {}", fs::path(kind.example).stem().string() + "_{grid}" +
                                                          fs::path(kind.example).extension().string()));
  }
  return name.uses(batch::OutputWord::frame);
}

Result<std::vector<std::uint64_t>> frame_steps(const SequenceFlags& flags, const SequenceKind& kind, bool is_sequence) {
  const std::uint64_t steps = flags.steps.value_or(kind.steps);
  if (!is_sequence) {
    if (!flags.every) return std::vector{steps};
    return refuse_usage(
        fmt::format("--every {} makes several frames, but the file name {} has no placeholder for the frame number",
                    *flags.every, *flags.output),
        fmt::format("write -o {}", kind.example));
  }
  const std::uint64_t every = flags.every.value_or(kind.every);
  if (steps % every != 0) {
    return refuse_usage(
        fmt::format("--steps {}: expected a multiple of --every ({}{}); otherwise the last steps are in no frame",
                    steps, every, flags.every ? "" : " by default"),
        fmt::format("for example --steps {}", steps + every - steps % every));
  }
  if (steps / every + 1 - kind.first > batch::kMaxFrames) {
    return refuse_usage(
        fmt::format("--steps {} --every {}: expected at most {} frames", steps, every, batch::kMaxFrames));
  }
  std::vector<std::uint64_t> frames;
  for (std::uint64_t step = kind.first * every; step <= steps; step += every) frames.push_back(step);
  return frames;
}

Result<void> check_taps(const std::vector<simulate::WaterTap>& taps, glm::ivec2 size, std::string_view option) {
  for (const simulate::WaterTap& tap : taps) {
    if (tap.cell.x >= 0 && tap.cell.y >= 0 && tap.cell.x < size.x && tap.cell.y < size.y) continue;
    return refuse_usage(fmt::format("{} {},{},{}: expected a cell within the grid of {} x {}, counted from 0,0", option,
                                    tap.cell.x, tap.cell.y, tap.rate, size.x, size.y));
  }
  return {};
}

}  // namespace

Result<SequencePlan> plan_sequence(const SequenceFlags& flags, const SequenceKind& kind) {
  if (!flags.output || flags.output->empty()) {
    return refuse_usage("expected -o FILE, the output file of the simulation, found none",
                        fmt::format("for example -o {}", kind.example));
  }
  const auto is_sequence = TRY(names_sequence(*flags.output, kind));
  const auto steps = TRY(frame_steps(flags, kind, is_sequence));
  std::vector<batch::OutputSource> sources;
  for (std::size_t frame = 0; frame < steps.size(); ++frame) {
    for (const std::string& grid : kind.grids) {
      sources.push_back(
          {static_cast<std::int64_t>(frame + kind.first), std::string(field::kDemoPrefix) + kind.stem, grid, {}});
    }
  }
  const auto named = TRY(batch::name_outputs(sources, flags.output, mesh_io::MeshFormat::glb, kind.extension));
  SequencePlan plan;
  plan.steps = steps.back();
  auto files = named.begin();
  for (const std::uint64_t step : steps) {
    SequenceFrame frame{step, {}};
    for (std::size_t grid = 0; grid < kind.grids.size(); ++grid) frame.files.emplace_back((files++)->front().path);
    plan.frames.push_back(std::move(frame));
  }
  plan.no_clobber = flags.no_clobber;
  plan.make_folders = flags.make_folders || flags.output->ends_with('/');
  plan.memory = plan_memory(flags.memory_limit);
  return plan;
}

Result<WaterPlan> plan_water(const WaterFlags& flags) {
  WaterPlan plan;
  plan.terrain.size = flags.size.value_or(plan.terrain.size);
  plan.terrain.seed = flags.seed.value_or(plan.terrain.seed);
  plan.terrain.relief = flags.relief.value_or(plan.terrain.relief);
  plan.level = flags.level;
  plan.depth = flags.depth;
  plan.default_scene = flags.sources.empty() && !flags.level && !flags.depth;
  plan.water.rule = flags.rule.value_or(plan.water.rule);
  plan.water.friction = flags.friction.value_or(plan.water.friction);
  plan.water.flow_div = flags.flow_div.value_or(plan.water.flow_div);
  plan.water.sources = flags.sources;
  plan.water.drains = flags.drains;
  TRY(check_taps(flags.sources, plan.terrain.size, flags.sources.name()));
  TRY(check_taps(flags.drains, plan.terrain.size, flags.drains.name()));
  plan.what = flags.what.value_or(plan.what);
  plan.spacing = flags.spacing.value_or(plan.spacing);
  SequenceKind kind{"water", kWaterExample, "", simulate::field_names(plan.what), kWaterSteps, kWaterEvery};
  if (flags.sequence.output && !flags.sequence.output->empty()) {
    const auto format =
        TRY(format_of_output(flags.format, *flags.sequence.output, volume_io::volume_file_format_by_path));
    plan.format = format;
    kind.extension = word_of(plan.format);
    kind.example = std::string(fs::path(kWaterExample).replace_extension(kind.extension));
    if (plan.format == volume_io::VolumeFileFormat::vdb && plan.what == simulate::WaterOutput::both) kind.grids = {""};
  }
  if (plan.what == simulate::WaterOutput::heights) {
    if (flags.sequence.output && plan.format != volume_io::VolumeFileFormat::npy) {
      return refuse_usage("--what heights writes NPY arrays", "give an output name that ends in .npy");
    }
    if (flags.spacing) {
      return refuse_usage("--spacing sets the distance between voxels, but --what heights writes no voxels",
                          "leave --spacing out");
    }
  }
  plan.sequence = TRY(plan_sequence(flags.sequence, kind));
  return plan;
}

}  // namespace isoextract::cli
