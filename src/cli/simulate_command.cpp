#include "cli/simulate_command.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/byte_size.hpp"
#include "base/counted.hpp"
#include "base/machine.hpp"
#include "base/printable.hpp"
#include "base/stopwatch.hpp"
#include "cli/output_folders.hpp"
#include "cli/planned_command.hpp"
#include "cli/progress_bar.hpp"
#include "convert/output_checks.hpp"
#include "files/output_file.hpp"
#include "simulate/water_fields.hpp"
#include "volume_io/grid_tools.hpp"
#include "volume_io/volume_writer.hpp"

namespace isoextract::cli {
namespace {

namespace fs = std::filesystem;

// The default scene: a spring in the hills, and a basin with a little water.
void add_default_scene(const simulate::TerrainOptions& terrain, simulate::WaterOptions& water, double& level) {
  water.sources.push_back({{terrain.size.x / 8, terrain.size.y / 2}, std::max(terrain.size.x, terrain.size.y) / 32.0});
  level = simulate::kMinLandHeight + terrain.relief / 12;
}

class WaterRun {
 public:
  WaterRun(const WaterPlan& plan, const Messages& messages)
      : plan_(plan), messages_(messages), context_(plan.sequence.memory) {}

  Result<void> run() {
    auto frames = TRY(check_sequence(plan_.sequence));
    const std::size_t left = plan_.sequence.frames.size() - frames.size();
    if (left > 0)
      messages_.note(
          {NoteId::frames_kept, fmt::format("{} of {} frames exist already; the simulation does not overwrite them",
                                            left, plan_.sequence.frames.size())});
    if (frames.empty()) return {};
    if (plan_.format == volume_io::VolumeFileFormat::vdb) {
      TRY(volume_io::check_grid_tools(frames.front().files.front().string()));
    }
    // The limit is that of the conservative rule; the printed rule comes to rest with less friction.
    if (plan_.water.rule == simulate::WaterRule::conservative && plan_.water.flow_div * plan_.water.friction < 4) {
      messages_.note(
          {NoteId::simulation_limits,
           fmt::format(
               "the water does not come to rest with --flow-div {} and --friction {}, because their product is below 4",
               plan_.water.flow_div, plan_.water.friction)});
    }
    auto automaton = TRY(make_automaton());
    const ProgressBar bar(context_.progress(), messages_.verbosity() != Verbosity::quiet);
    context_.progress().begin("simulating", frames.back().step);
    for (const SequenceFrame& frame : frames) {
      const Stopwatch watch;
      TRY(automaton.run(frame.step - automaton.steps_done()));
      seconds_ += watch.elapsed().wall_seconds;
      const Stopwatch write_watch;
      TRY(write(automaton, frame));
      write_seconds_ += write_watch.elapsed().wall_seconds;
    }
    tell(automaton, frames);
    return {};
  }

 private:
  Result<simulate::WaterAutomaton> make_automaton() {
    auto terrain = TRY(simulate::make_terrain(plan_.terrain, context_));
    const auto heights = terrain->values.span();
    simulate::WaterOptions water = plan_.water;
    double level = plan_.level.value_or(0);
    if (plan_.default_scene) add_default_scene(plan_.terrain, water, level);
    auto depth = TRY(make_reserved_buffer<double>(heights.size(), context_, "the water"));
    std::ranges::transform(heights, depth->values.begin(),
                           [&](double height) { return std::max(level - height, 0.0) + plan_.depth.value_or(0); });
    return simulate::WaterAutomaton::create(plan_.terrain.size, heights, depth->values.span(), std::move(water),
                                            context_);
  }

  Result<void> write(const simulate::WaterAutomaton& automaton, const SequenceFrame& frame) {
    if (plan_.what != simulate::WaterOutput::heights) {
      const auto layers = TRY(simulate::count_layers(automaton));
      // All frames get the same number of layers, unless the water rises above it.
      if (layers > layers_) {
        layers_ = layers;
        grown_.emplace_back(frame.files.front().string(), layers_);
      }
    }
    const auto fields = TRY(simulate::water_fields(automaton, plan_.what, layers_, plan_.spacing, context_));
    const std::span all(fields);
    for (std::size_t f = 0; f < frame.files.size(); ++f) {
      // A single file holds all grids.
      const auto bytes = TRY(volume_io::write_volume(frame.files[f], frame.files.size() == 1 ? all : all.subspan(f, 1),
                                                     plan_.format, context_));
      bytes_ += bytes;
    }
    return context_.check();
  }

  void tell(const simulate::WaterAutomaton& automaton, const std::vector<SequenceFrame>& frames) const {
    const simulate::WaterBalance balance = automaton.balance();
    const simulate::WaterExtremes found = automaton.extremes();
    const glm::ivec2 size = automaton.size();
    const double cells = static_cast<double>(size.x) * size.y * static_cast<double>(automaton.steps_done());
    messages_.summary(fmt::format("{} of {} x {} cells by the {} rule: {:.1f} million cells per second",
                                  counted(automaton.steps_done(), "step"), size.x, size.y, word_of(plan_.water.rule),
                                  seconds_ > 0 ? 1e-6 * cells / seconds_ : 0));
    messages_.summary(
        fmt::format("water: {:.6g} at the start, {:.6g} poured, {:.6g} drained, {:.6g} at the end; relative imbalance "
                    "{:.1e}; depths {:.4g} to {:.4g}",
                    balance.at_start, balance.poured, balance.drained, balance.there, balance.drift(),
                    found.least_depth, found.max_depth));
    if (found.below_zero > 0) {
      messages_.note(
          {NoteId::simulation_limits,
           fmt::format("{} of {} cells have a depth below 0, which the printed rule allows{}", found.below_zero,
                       std::int64_t{size.x} * size.y,
                       plan_.what == simulate::WaterOutput::heights ? "" : "; volumes have no water there")});
    }
    for (std::size_t g = 1; g < grown_.size(); ++g) {
      messages_.note(
          {NoteId::simulation_limits,
           fmt::format("{}: the water rises, so volumes have {} instead of {} from this file on",
                       printable(grown_[g].first), counted(grown_[g].second, "layer"), grown_[g - 1].second)});
    }
    tell_how_to_read(frames);
    std::size_t files = 0;
    for (const SequenceFrame& frame : frames) files += frame.files.size();
    const std::string first = printable(frames.front().files.front().string());
    messages_.summary(files == 1 ? fmt::format("-> {} ({})", first, format_byte_size(bytes_))
                                 : fmt::format("-> {} to {}: {} files, {}", first,
                                               printable(frames.back().files.back().string()), files,
                                               format_byte_size(bytes_)));
    messages_.detail(simulation_times_text(seconds_, write_seconds_));
  }

  // Prints the options for reading files whose header lacks dimensions or placement.
  void tell_how_to_read(const std::vector<SequenceFrame>& frames) const {
    const bool raw = plan_.format == volume_io::VolumeFileFormat::raw;
    if (plan_.what == simulate::WaterOutput::heights || (!raw && plan_.format != volume_io::VolumeFileFormat::npy))
      return;
    const glm::dvec3& s = plan_.spacing;
    std::string options;
    if (raw)
      options += fmt::format(" --dims {},{},{} --dtype f32", plan_.terrain.size.x, plan_.terrain.size.y, layers_);
    if (s != glm::dvec3(1.0)) options += fmt::format(" --spacing {},{},{}", s.x, s.y, s.z);
    options += fmt::format(" --origin {},{},{}", 0.5 * s.x, 0.5 * s.y, 0.5 * s.z);
    messages_.summary(fmt::format("read with: isoextract {} --iso 0.5{}",
                                  shell_quoted(frames.back().files.back().string()), options));
  }

  const WaterPlan& plan_;
  const Messages& messages_;
  Context context_;
  int layers_ = 1;
  // The first file with each number of layers, including the very first.
  std::vector<std::pair<std::string, int>> grown_;
  double seconds_ = 0;        // of the simulation
  double write_seconds_ = 0;  // of the files
  std::uint64_t bytes_ = 0;
};

struct SimulateFlags : OptionSet {
  RunFlags run{*this, RunFlags::Taken::help};
};

// Prints its synopsis as an error; the subcommands simulate.
class SimulateCommand final : public CommandOf<SimulateFlags> {
 public:
  SimulateCommand() : CommandOf({"simulate", "", "Simulate water or a jet, and write its frames."}) {}

  Result<int> run(const std::vector<std::string>& /*arguments*/) override {
    return fail(ErrorCode::usage,
                fmt::format("{} needs a subcommand, one of {}", name(), fmt::join(inner_names(), ", ")), synopsis());
  }
};

Result<void> run_water(const WaterPlan& plan, const Messages& messages) { return WaterRun(plan, messages).run(); }

}  // namespace

Result<std::vector<SequenceFrame>> check_sequence(const SequencePlan& plan) {
  std::vector<SequenceFrame> frames;
  std::vector<fs::path> files;
  for (const SequenceFrame& frame : plan.frames) {
    const bool leave = plan.no_clobber && std::ranges::any_of(frame.files, files::is_there);
    if (leave) continue;
    frames.push_back(frame);
    files.insert(files.end(), frame.files.begin(), frame.files.end());
  }
  TRY(check_or_make_folders(files, plan.make_folders));
  for (const fs::path& file : files) {
    if (file == "-") continue;
    TRY(convert::check_output_file(file, {}));
  }
  return frames;
}

std::string simulation_times_text(double simulating, double writing) {
  return fmt::format("simulated in {:.2f} s, written in {:.2f} s, peak memory {}", simulating, writing,
                     format_byte_size(peak_memory()));
}

std::unique_ptr<Command> make_simulate_command() {
  auto simulate = std::make_unique<SimulateCommand>();
  simulate->add(std::make_unique<PlannedCommand<WaterFlags, plan_water, run_water>>(
      CommandWords{"water", "-o FILE [options]", "Simulate water over hills, by a cellular automaton."}));
  simulate->add(make_jet_command());
  return simulate;
}

}  // namespace isoextract::cli
