// The options of the simulate commands.
#pragma once

#include <cstdint>
#include <string>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "cli/option.hpp"
#include "cli/options/run.hpp"
#include "cli/values.hpp"
#include "particle_io/particle_writer.hpp"
#include "simulate/particle_jet.hpp"
#include "simulate/terrain.hpp"
#include "simulate/water.hpp"
#include "simulate/water_fields.hpp"
#include "volume_io/volume_writer.hpp"

namespace isoextract::cli {

inline constexpr std::uint64_t kWaterSteps = 400;
inline constexpr std::uint64_t kWaterEvery = 10;
inline constexpr const char* kWaterExample = "water_{:04}.nrrd";
inline constexpr std::uint64_t kJetFrames = 120;
inline constexpr const char* kJetExample = "jet_{:04}.ply";

// The length of a simulation, and the files that it writes.
struct SequenceFlags : OptionSet {
  // `example` is an example of -o, `formats` the help about formats. Without `takes_steps` there are no --steps and
  // --every; the command has its own options for the frames.
  SequenceFlags(OptionSet& command, std::string example, std::string formats, bool takes_steps);

 private:
  std::string example_;
  std::string formats_;
  bool takes_steps_;
  Place steps_place() { return takes_steps_ ? in(OptionGroup::simulation) : Place(); }

 public:
  Value<std::uint64_t> steps{steps_place(), "--steps", "N", parse_count,
                             fmt::format("Steps to simulate (default: {}).", kWaterSteps)};
  Value<std::uint64_t> every{
      steps_place(), "--every", "K", parse_positive_count,
      fmt::format("Steps from one frame to the next (default: {}). Frame 0 is the start.", kWaterEvery)};
  Value<std::string> output{
      *this, "-o,--output", "FILE", parse_text,
      fmt::format("Output files, such as {}; required. {{:04}}, %04d or #### stands for the frame number. A name that "
                  "ends in a slash is a folder, and needs --format. A name without a number gets the last frame alone. "
                  "{} A file gets its name when it is complete.",
                  example_, formats_)};
  Flag no_clobber{*this, "--no-clobber", "Skip frames whose output exists already."};
  Flag make_folders{*this, "--mkdir", "Create missing output folders. A slash at the end of -o does so, too."};
  Value<std::uint64_t> memory_limit{
      *this, "--memory-limit", "SIZE", parse_memory_size,
      "Limit for cells and particles, such as 512M or 8G. A simulation that needs more is "
      "refused. Default: the memory that the machine or its container allows."};
};

struct WaterFlags : OptionSet {
  WaterFlags();

 private:
  simulate::TerrainOptions land_;

 public:
  Value<glm::ivec2> size{in(OptionGroup::scene), "--size", "NXxNY", parse_grid_size,
                         fmt::format("Cells along x and y (default: {}x{}).", land_.size.x, land_.size.y)};
  Value<std::uint64_t> seed{in(OptionGroup::scene), "--seed", "N", parse_count,
                            fmt::format("Seed of the noise that shapes the hills (default: {}).", land_.seed)};
  Value<double> relief{in(OptionGroup::scene), "--relief", "H", parse_not_negative,
                       fmt::format("Height of the highest cell over the lowest, in cells. 0 is flat land. Default: {}. "
                                   "The lowest cell is at height {}.",
                                   land_.relief, simulate::kMinLandHeight)};
  Value<double> level{in(OptionGroup::scene), "--level", "H", parse_not_negative,
                      "Water level that fills the land at the start."};
  Value<double> depth{in(OptionGroup::scene), "--depth", "D", parse_not_negative,
                      "Water over every cell at the start. It comes on top of --level."};
  Values<simulate::WaterTap> sources{
      in(OptionGroup::scene), "--source", "X,Y,RATE", parse_tap,
      "Water that flows into a cell in every step. X,Y is the cell, counted from 0,0; RATE is the depth that it gets. "
      "Several times for several cells. Without --source, --level and "
      "--depth there is one source in the hills and some water in the basin."};
  Values<simulate::WaterTap> drains{in(OptionGroup::scene), "--drain", "X,Y,RATE", parse_tap,
                                    "Most water that leaves a cell in every step. X,Y is the cell, counted from 0,0; "
                                    "RATE is a depth. Several times for several cells."};
  Value<simulate::WaterRule> rule{
      in(OptionGroup::simulation), "--rule",
      "Rule of the flow (default: conservative). conservative loses no water and never falls below 0. printed follows "
      "the paper's listing literally, with its signs and order, and can fall below 0. docs/simulate.md explains both."};
  Value<double> friction{
      in(OptionGroup::simulation), "--friction", "F", parse_part,
      fmt::format("Share of the energy that water loses in a step, 0 to 1. Default: {}.", simulate::kDefaultFriction)};
  Value<double> flow_div{in(OptionGroup::simulation), "--flow-div", "D", parse_one_or_more,
                         fmt::format("Divisor of the flow between neighbors, 1 or more. The flow is the difference of "
                                     "levels, or the depth of water if that is less, divided by D. Water comes to rest "
                                     "if D is above 4 / F, F being --friction, with --rule conservative. Default: {}.",
                                     simulate::kDefaultFlowDiv)};
  SequenceFlags sequence{
      *this, kWaterExample,
      "The extension, .nrrd, .npy, .raw, .vdb or .vti, chooses the format. '-' is stdout and needs --format. "
      "'{grid}' stands for terrain or water: --what both writes each into its own file, except as .vdb.",
      true};
  Value<volume_io::VolumeFileFormat> format{in(OptionGroup::output), "--format",
                                            "Format of the output, whatever the extension."};
  Value<simulate::WaterOutput> what{
      in(OptionGroup::output), "--what",
      "What to write (default: water). water, terrain and both are volumes of the filled share of each voxel, 0 to 1, "
      "z up: extract them at iso value 0.5. heights is the height of the land and the depth of the water, as NPY "
      "arrays [y, x] of f64. With both, a .vdb file has two grids."};
  Value<glm::dvec3> spacing{in(OptionGroup::output), "--spacing", "SX,SY,SZ", parse_spacing,
                            "Voxel size in the output (default: 1). One number is for all axes."};
  RunFlags run{*this};
};

struct JetFlags : OptionSet {
  JetFlags();

 private:
  simulate::JetOptions jet_;

 public:
  Value<std::uint64_t> count{in(OptionGroup::scene), "--count", "N", parse_positive_count,
                             fmt::format("Particles in the tank at the end (default: {}).", jet_.count)};
  Value<double> radius{in(OptionGroup::scene), "--radius", "R", parse_positive,
                       "Radius of a particle; at rest they are 2 radii apart. Default: so that all particles fill a "
                       "tenth of the tank, but at most the nozzle's radius apart."};
  Value<glm::dvec3> tank{
      in(OptionGroup::scene), "--tank", "XxYxZ", parse_sides,
      fmt::format("Sides of the tank, z up (default: {}). One number is for all sides. The center is the origin. In "
                  ".bgeo files y is up, as in Houdini: (x, y, z) becomes (x, z, -y).",
                  jet_.tank.x)};
  Value<double> nozzle{in(OptionGroup::scene), "--nozzle", "R", parse_positive,
                       "Radius of the nozzle. It is in the wall at the smallest x, three quarters up. Default: a "
                       "twelfth of the shorter of the tank's sides Y and Z."};
  Value<double> speed{
      in(OptionGroup::scene), "--speed", "V", parse_positive,
      fmt::format("Speed of particles that leave the nozzle. In the tank's unit per second. Default: {}.", jet_.speed)};
  Value<std::uint64_t> seed{in(OptionGroup::scene), "--seed", "N", parse_count,
                            fmt::format("Seed of the offsets of particles at the nozzle. Default: {}.", jet_.seed)};
  Value<std::uint64_t> frames{
      in(OptionGroup::simulation), "--frames", "N", parse_positive_count,
      fmt::format("Frames to simulate (default: {}). The first is one frame's time after the nozzle opens.",
                  kJetFrames)};
  Value<double> fps{in(OptionGroup::simulation), "--fps", "F", parse_positive,
                    fmt::format("Frames per second (default: {}). A frame has several steps; in each, no particle "
                                "moves more than 0.8 particle distances.",
                                jet_.fps)};
  Value<double> gravity{in(OptionGroup::simulation), "--gravity", "G", parse_not_negative,
                        fmt::format("Gravity along -z (default: {}). In the tank's unit per second squared; the "
                                    "default is the Earth's if the unit is a decimeter.",
                                    jet_.gravity)};
  Value<double> viscosity{
      in(OptionGroup::simulation), "--viscosity", "C", parse_not_negative,
      fmt::format("Share by which neighbors even out their velocities. From 0 to 0.5, in each step. Default: {}.",
                  jet_.viscosity)};
  Value<std::uint64_t> iterations{
      in(OptionGroup::simulation), "--iterations", "N", parse_positive_count,
      fmt::format("Solver iterations per step (default: {}). 1 to 1000. More iterations compress the liquid less.",
                  jet_.iterations)};
  SequenceFlags sequence{
      *this, kJetExample,
      "The extension, .ply, .npy, .xyz, .bgeo or .vtu, chooses the format. '-' is stdout and needs --format.", false};
  Value<particle_io::ParticleFileFormat> format{in(OptionGroup::output), "--format",
                                                "Format of the output, whatever the extension."};
  RunFlags run{*this};
};

}  // namespace isoextract::cli
