#include "cli/simulate_options.hpp"

#include <fmt/format.h>

#include "cli/jet_options.hpp"
#include "cli/shared_options.hpp"
#include "cli/simulate_plan.hpp"
#include "simulate/terrain.hpp"

namespace isoextract::cli {
namespace {

void declare_water(CLI::App& app, WaterFlags& flags) {
  const simulate::TerrainOptions land;
  const Group scene(app, "Scene");
  scene.value("--size", "NXxNY", flags.size, parse_grid_size,
              fmt::format("Cells along x and y (default: {}x{}).", land.size.x, land.size.y));
  scene.value(
      "--seed", "N", flags.seed, parse_count,
      fmt::format("Of the noise that the hills are made of: another number, other hills (default: {}).", land.seed));
  scene.value(
      "--relief", "H", flags.relief, parse_not_negative,
      fmt::format("How far the highest cell of the land is above the lowest, in cells; 0 is even land (default: "
                  "{}). The lowest is at height {}.",
                  land.relief, simulate::kLowestLand));
  scene.value("--level", "H", flags.level, parse_not_negative,
              "Fill the land with water up to this height at the start.");
  scene.value("--depth", "D", flags.depth, parse_not_negative,
              "Pour so much water over every cell at the start, on top of what --level gives.");
  scene.values("--source", "X,Y,RATE", flags.sources, parse_tap,
               "Pour so much water into a cell in every step; several times for several cells. Where neither this nor "
               "--level nor --depth is given, there is one up in the hills, and a little water in the basin.");
  scene.values("--drain", "X,Y,RATE", flags.drains, parse_tap,
               "Take so much water at most out of a cell in every step; several times for several cells.");
  const Group simulation(app, "Simulation");
  simulation.choice(
      "--rule", flags.rule,
      "How water moves: conservative loses none and has none below 0; printed is the paper's listing, signs "
      "and order as they stand, and goes below 0 (default: conservative). docs/simulate.md has both.");
  simulation.value(
      "--friction", "F", flags.friction, parse_part,
      fmt::format("The part of its energy that water loses, 0 to 1 (default: {}).", simulate::kDefaultFriction));
  simulation.value("--flow-div", "D", flags.flow_div, parse_one_or_more,
                   fmt::format("What flows between neighbours is their difference over this, 1 or more; water comes to "
                               "rest where it is above 4 / F (default: {}).",
                               simulate::kDefaultFlowDiv));
  declare_steps(simulation, flags.sequence, kWaterSteps, kWaterEvery);
  const Group output(app, "Output");
  declare_sequence_output(
      output, flags.sequence, kWaterExample,
      "The extension, .nrrd, .npy, .raw or .vdb, chooses the format. '-' is stdout and needs --format. "
      "'{grid}' stands for terrain or water, where --what writes both into files of their own.");
  output.choice("--format", flags.format, "Format of the output, whatever the extension.");
  output.choice(
      "--what", flags.what,
      "What is written: for water, terrain or both a volume in which each voxel says how much of it is "
      "filled, 0 to 1, z up, to extract at iso value 0.5; for heights the land's height and the water's depth as "
      "NPY arrays [y, x] of f64 (default: water). A .vdb holds both as two grids.");
  output.value("--spacing", "SX,SY,SZ", flags.spacing, parse_spacing,
               "Size of a voxel in the output, or one number for all axes (default: 1).");
  declare_run(app, flags.run);
}

}  // namespace

void declare_steps(const Group& group, SequenceFlags& flags, std::uint64_t steps, std::uint64_t every) {
  group.value("--steps", "N", flags.steps, parse_count, fmt::format("Steps to simulate (default: {}).", steps));
  group.value(
      "--every", "K", flags.every, parse_positive_count,
      fmt::format("Steps from one frame of the output to the next; frame 0 is the start (default: {}).", every));
}

void declare_sequence_output(const Group& group, SequenceFlags& flags, const std::string& example,
                             const std::string& what) {
  group.value<std::string>(
      "-o,--output", "FILE", flags.output, parse_text,
      fmt::format("Required: the files, such as {}, a number for each frame in the place of {{:04}}, "
                  "%04d or ####; a folder, with a slash at its end; or one file without a number, for the "
                  "last step alone. {} A file gets its name when it is whole.",
                  example, what));
  group.flag("--no-clobber", flags.no_clobber, "Leave files alone that are there, whoever wrote them.");
  group.flag("--mkdir", flags.make_folders, "Make the folders of the outputs; so does a slash at the end of -o.");
  group.value(
      "--memory-limit", "SIZE", flags.memory_limit, parse_size,
      "Refuse a simulation that needs more memory than this, such as 512M or 8G (default: the machine's memory).");
}

void declare_simulate(CommandLine& line) {
  Group(*line.simulate, "Run").help_flag();
  line.simulate->require_subcommand(1);
  const auto add = [&](const char* name, const char* description) {
    CLI::App* command = line.simulate->add_subcommand(name, description);
    command->allow_extras();  // the caller names what is unknown, with a suggestion
    return command;
  };
  line.simulate_water = add("water", "Let water run over hilly land, by a cellular automaton, as volumes.");
  declare_water(*line.simulate_water, line.water_flags);
  line.simulate_jet = add("jet", "Let a jet of water into a tank, by position-based fluids, as particles.");
  declare_jet(*line.simulate_jet, line.jet_flags);
}

}  // namespace isoextract::cli
