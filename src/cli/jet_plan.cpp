#include "cli/jet_plan.hpp"

#include <algorithm>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "batch/frame_range.hpp"
#include "batch/output_template.hpp"
#include "cli/plan_parts.hpp"

namespace isoextract::cli {
Result<JetPlan> plan_jet(const JetFlags& flags) {
  JetPlan plan;
  simulate::JetOptions& jet = plan.jet;
  jet.count = flags.count.value_or(jet.count);
  jet.radius = flags.radius;
  jet.tank = flags.tank.value_or(jet.tank);
  jet.nozzle = flags.nozzle;
  jet.speed = flags.speed.value_or(jet.speed);
  jet.gravity = flags.gravity.value_or(jet.gravity);
  jet.fps = flags.fps.value_or(jet.fps);
  jet.viscosity = flags.viscosity.value_or(jet.viscosity);
  jet.seed = flags.seed.value_or(jet.seed);
  if (flags.iterations) {
    constexpr std::uint64_t kMost = std::numeric_limits<int>::max();
    jet.iterations = static_cast<int>(std::min(*flags.iterations, kMost));  // clamped values are refused as well
  }
  const std::uint64_t frames = flags.frames.value_or(kJetFrames);
  if (frames > batch::kMaxFrames) {
    return refuse_usage(fmt::format("--frames {}: expected at most {} frames", frames, batch::kMaxFrames));
  }
  SequenceFlags sequence = flags.sequence;
  sequence.steps = frames;
  SequenceKind kind{.stem = "jet", .example = kJetExample, .extension = "", .grids = {""}, .steps = frames, .first = 1};
  if (sequence.output && !sequence.output->empty()) {
    const auto format =
        TRY(format_of_output(flags.format, *flags.sequence.output, particle_io::particle_file_format_by_path));
    plan.format = format;
    kind.extension = word_of(plan.format);
  }
  plan.sequence = TRY(plan_sequence(sequence, kind));
  const auto name = batch::OutputTemplate::parse(*sequence.output);
  if (name && name->uses(batch::OutputWord::frame) && !name->uses(batch::OutputWord::stem) &&
      !sequence.output->ends_with('/')) {
    plan.pattern = *sequence.output;
  }
  return plan;
}

}  // namespace isoextract::cli
