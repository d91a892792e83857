#include "cli/jet_options.hpp"

#include <fmt/format.h>

#include "cli/jet_plan.hpp"
#include "cli/option_group.hpp"
#include "cli/shared_options.hpp"
#include "cli/simulate_options.hpp"

namespace isoextract::cli {

void declare_jet(CLI::App& app, JetFlags& flags) {
  const simulate::JetOptions jet;
  const Group scene(app, "Scene");
  scene.value("--count", "N", flags.count, parse_positive_count,
              fmt::format("Particles that the tank holds in the end (default: {}).", jet.count));
  scene.value(
      "--radius", "R", flags.radius, parse_positive,
      "Radius of a particle: at rest they are two radii apart (default: so that all of them fill a tenth of the "
      "tank, but not wider apart than the nozzle's radius).");
  scene.value("--tank", "XxYxZ", flags.tank, parse_sides,
              fmt::format("Sides of the tank, z up, or one number for all; its middle is the origin (default: {}).",
                          jet.tank.x));
  scene.value("--nozzle", "R", flags.nozzle, parse_positive,
              "Radius of the nozzle, which is in the wall at the least x, three quarters up (default: a twelfth of the "
              "shorter of the tank's width and height).");
  scene.value("--speed", "V", flags.speed, parse_positive,
              fmt::format("Speed of the particles that leave the nozzle, in the tank's unit a second (default: {}).",
                          jet.speed));
  scene.value(
      "--seed", "N", flags.seed, parse_count,
      fmt::format("Of the numbers by which particles are off the lattice on which they leave the nozzle: another "
                  "number, other splashes (default: {}).",
                  jet.seed));
  const Group simulation(app, "Simulation");
  simulation.value(
      "--frames", "N", flags.frames, parse_positive_count,
      fmt::format("Frames to simulate; the first is one frame's time after the nozzle was opened (default: "
                  "{}).",
                  kJetFrames));
  simulation.value("--fps", "F", flags.fps, parse_positive,
                   fmt::format("Frames a second. A frame is as many steps as the fastest particle needs to move no "
                               "farther than 0.8 particle distances in each (default: {}).",
                               jet.fps));
  simulation.value(
      "--gravity", "G", flags.gravity, parse_not_negative,
      fmt::format("Towards -z, in the tank's unit a second squared; the default is that of the Earth where "
                  "the unit is a decimetre (default: {}).",
                  jet.gravity));
  simulation.value(
      "--viscosity", "C", flags.viscosity, parse_not_negative,
      fmt::format("How much velocities are evened out between neighbours in a step, 0 to 0.5 (default: {}).",
                  jet.viscosity));
  simulation.value(
      "--iterations", "N", flags.iterations, parse_positive_count,
      fmt::format("Of the solver in a step; more of them compress the liquid less (default: {}).", jet.iterations));
  const Group output(app, "Output");
  declare_sequence_output(output, flags.sequence, kJetExample,
                          "The extension, .ply, .npy or .xyz, chooses the format. '-' is stdout and needs --format.");
  output.choice("--format", flags.format, "Format of the output, whatever the extension.");
  declare_run(app, flags.run);
}

}  // namespace isoextract::cli
