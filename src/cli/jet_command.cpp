// `isoextract simulate jet`: writes a particle jet, frame by frame.
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/byte_size.hpp"
#include "base/context.hpp"
#include "base/counted.hpp"
#include "base/printable.hpp"
#include "base/stopwatch.hpp"
#include "cli/jet_plan.hpp"
#include "cli/planned_command.hpp"
#include "cli/progress_bar.hpp"
#include "cli/simulate_command.hpp"
#include "points/method.hpp"

namespace isoextract::cli {
namespace {

class JetRun {
 public:
  JetRun(const JetPlan& plan, const Messages& messages)
      : plan_(plan), messages_(messages), work_(plan.sequence.memory), shown_(plan.sequence.memory) {}

  Result<void> run() {
    const auto frames = TRY(check_sequence(plan_.sequence));
    const std::size_t left = plan_.sequence.frames.size() - frames.size();
    if (left > 0)
      messages_.note(
          {NoteId::frames_kept, fmt::format("{} of {} frames exist already; the simulation does not overwrite them",
                                            left, plan_.sequence.frames.size())});
    if (frames.empty()) return {};
    auto jet = TRY(simulate::ParticleJet::make(plan_.jet, work_));
    {
      const ProgressBar bar(shown_.progress(), messages_.verbosity() != Verbosity::quiet);
      shown_.progress().begin("simulating", frames.back().step);
      for (const SequenceFrame& frame : frames) {
        TRY(advance(jet, frame));
      }
    }
    tell(jet, frames);
    return {};
  }

 private:
  Result<void> advance(simulate::ParticleJet& jet, const SequenceFrame& frame) {
    while (jet.figures().frames < frame.step) {
      const Stopwatch watch;
      TRY(jet.advance(work_));
      seconds_ += watch.elapsed().wall_seconds;
      shown_.progress().advance(1);
    }
    const Stopwatch write_watch;
    const auto particles =
        TRY(jet.particles(work_, particle_io::is_y_up(plan_.format) ? simulate::JetUp::y : simulate::JetUp::z));
    const auto bytes = TRY(particle_io::write_particles(frame.files.front(), particles, plan_.format));
    bytes_ += bytes;
    write_seconds_ += write_watch.elapsed().wall_seconds;
    return {};
  }

  void tell(const simulate::ParticleJet& jet, const std::vector<SequenceFrame>& frames) const {
    const simulate::JetFigures figures = jet.figures();
    const double moved = static_cast<double>(figures.particle_steps);
    messages_.summary(fmt::format(
        "{} of radius {:.6g} in the tank; {} in {}: {:.2f} million particles moved, {:.3f} million per second",
        counted(jet.size(), "particle"), jet.radius(), counted(figures.frames, "frame"), counted(figures.steps, "step"),
        1e-6 * moved, seconds_ > 0 ? 1e-6 * moved / seconds_ : 0));
    if (jet.size() < plan_.jet.count) {
      messages_.note({NoteId::simulation_limits,
                      fmt::format("{} of {} particles have not left the nozzle; simulate more frames to release them",
                                  plan_.jet.count - jet.size(), plan_.jet.count)});
    }
    if (figures.slowed_down > 0) {
      messages_.note(
          {NoteId::simulation_limits,
           fmt::format("the simulation slowed particles down {}, to twice the speed of a fall through the tank",
                       counted(figures.slowed_down, "time"))});
    }
    if (!plan_.pattern.empty()) tell_how_to_convert(jet.radius());
    const std::string first = printable(frames.front().files.front().string());
    messages_.summary(frames.size() == 1 ? fmt::format("-> {} ({})", first, format_byte_size(bytes_))
                                         : fmt::format("-> {} to {}: {} files, {}", first,
                                                       printable(frames.back().files.back().string()), frames.size(),
                                                       format_byte_size(bytes_)));
    messages_.detail(simulation_times_text(seconds_, write_seconds_));
  }

  // Suggests one radius for all frames, since only this gives all frames the same grid.
  void tell_how_to_convert(double radius) const {
    messages_.summary(
        fmt::format("convert with: isoextract {}{} --particles weight --iso {} --radius {:.12g} --animate "
                    "--fps {} -o jet.glb",
                    shell_quoted(plan_.pattern), particle_io::is_y_up(plan_.format) ? " --up y" : "",
                    points::method_info(points::Method::weight).iso, radius, plan_.jet.fps));
  }

  const JetPlan& plan_;
  const Messages& messages_;
  Context work_;
  Context shown_;             // for the progress bar, because the simulation counts its own steps
  double seconds_ = 0;        // of the simulation
  double write_seconds_ = 0;  // of the files
  std::uint64_t bytes_ = 0;
};

Result<void> run_jet(const JetPlan& plan, const Messages& messages) { return JetRun(plan, messages).run(); }

}  // namespace

std::unique_ptr<Command> make_jet_command() {
  return std::make_unique<PlannedCommand<JetFlags, plan_jet, run_jet>>(
      CommandWords{"jet", "-o FILE [options]", "Simulate a jet into a tank, by position-based fluids."});
}

}  // namespace isoextract::cli
