// The options of the commands that simulate.
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

// How much is simulated, and where its files go.
struct SequenceFlags : OptionSet {
  // `example` is one of -o, and `formats` what it says of them. Without `takes_steps` the frames are said otherwise.
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
      fmt::format("Steps from one frame of the output to the next; frame 0 is the start (default: {}).", kWaterEvery)};
  Value<std::string> output{
      *this, "-o,--output", "FILE", parse_text,
      fmt::format("Required: the files, such as {}, a number for each frame in the place of {{:04}}, %04d or ####; a "
                  "folder, with a slash at its end; or one file without a number, for the last step alone. {} A file "
                  "gets its name when it is whole.",
                  example_, formats_)};
  Flag no_clobber{*this, "--no-clobber", "Leave files alone that are there, whoever wrote them."};
  Flag make_folders{*this, "--mkdir", "Make the folders of the outputs; so does a slash at the end of -o."};
  Value<std::uint64_t> memory_limit{
      *this, "--memory-limit", "SIZE", parse_size,
      "Refuse a simulation that needs more memory than this, such as 512M or 8G (default: the machine's memory)."};
};

struct WaterFlags : OptionSet {
  WaterFlags();

 private:
  simulate::TerrainOptions land_;

 public:
  Value<glm::ivec2> size{in(OptionGroup::scene), "--size", "NXxNY", parse_grid_size,
                         fmt::format("Cells along x and y (default: {}x{}).", land_.size.x, land_.size.y)};
  Value<std::uint64_t> seed{in(OptionGroup::scene), "--seed", "N", parse_count,
                            fmt::format("Of the noise that the hills are made of: another number, other hills "
                                        "(default: {}).",
                                        land_.seed)};
  Value<double> relief{
      in(OptionGroup::scene), "--relief", "H", parse_not_negative,
      fmt::format("How far the highest cell of the land is above the lowest, in cells; 0 is even land (default: "
                  "{}). The lowest is at height {}.",
                  land_.relief, simulate::kLowestLand)};
  Value<double> level{in(OptionGroup::scene), "--level", "H", parse_not_negative,
                      "Fill the land with water up to this height at the start."};
  Value<double> depth{in(OptionGroup::scene), "--depth", "D", parse_not_negative,
                      "Pour so much water over every cell at the start, on top of what --level gives."};
  Values<simulate::Tap> sources{
      in(OptionGroup::scene), "--source", "X,Y,RATE", parse_tap,
      "Pour so much water into a cell in every step; several times for several cells. Where neither this nor "
      "--level nor --depth is given, there is one up in the hills, and a little water in the basin."};
  Values<simulate::Tap> drains{
      in(OptionGroup::scene), "--drain", "X,Y,RATE", parse_tap,
      "Take so much water at most out of a cell in every step; several times for several cells."};
  Value<simulate::WaterRule> rule{
      in(OptionGroup::simulation), "--rule",
      "How water moves: conservative loses none and has none below 0; printed is the paper's listing, signs "
      "and order as they stand, and goes below 0 (default: conservative). docs/simulate.md has both."};
  Value<double> friction{
      in(OptionGroup::simulation), "--friction", "F", parse_part,
      fmt::format("The part of its energy that water loses, 0 to 1 (default: {}).", simulate::kDefaultFriction)};
  Value<double> flow_div{
      in(OptionGroup::simulation), "--flow-div", "D", parse_one_or_more,
      fmt::format("What flows between neighbours is their difference over this, 1 or more; water comes to rest where "
                  "it is above 4 / F (default: {}).",
                  simulate::kDefaultFlowDiv)};
  SequenceFlags sequence{
      *this, kWaterExample,
      "The extension, .nrrd, .npy, .raw or .vdb, chooses the format. '-' is stdout and needs --format. "
      "'{grid}' stands for terrain or water, where --what writes both into files of their own.",
      true};
  Value<volume_io::VolumeFileFormat> format{in(OptionGroup::output), "--format",
                                            "Format of the output, whatever the extension."};
  Value<simulate::WaterContent> what{
      in(OptionGroup::output), "--what",
      "What is written: for water, terrain or both a volume in which each voxel says how much of it is "
      "filled, 0 to 1, z up, to extract at iso value 0.5; for heights the land's height and the water's depth as "
      "NPY arrays [y, x] of f64 (default: water). A .vdb holds both as two grids."};
  Value<glm::dvec3> spacing{in(OptionGroup::output), "--spacing", "SX,SY,SZ", parse_spacing,
                            "Size of a voxel in the output, or one number for all axes (default: 1)."};
  RunFlags run{*this};
};

struct JetFlags : OptionSet {
  JetFlags();

 private:
  simulate::JetOptions jet_;

 public:
  Value<std::uint64_t> count{in(OptionGroup::scene), "--count", "N", parse_positive_count,
                             fmt::format("Particles that the tank holds in the end (default: {}).", jet_.count)};
  Value<double> radius{
      in(OptionGroup::scene), "--radius", "R", parse_positive,
      "Radius of a particle: at rest they are two radii apart (default: so that all of them fill a tenth of the "
      "tank, but not wider apart than the nozzle's radius)."};
  Value<glm::dvec3> tank{
      in(OptionGroup::scene), "--tank", "XxYxZ", parse_sides,
      fmt::format("Sides of the tank, z up, or one number for all; its middle is the origin (default: {}).",
                  jet_.tank.x)};
  Value<double> nozzle{in(OptionGroup::scene), "--nozzle", "R", parse_positive,
                       "Radius of the nozzle, which is in the wall at the least x, three quarters up (default: a "
                       "twelfth of the shorter of the tank's width and height)."};
  Value<double> speed{
      in(OptionGroup::scene), "--speed", "V", parse_positive,
      fmt::format("Speed of the particles that leave the nozzle, in the tank's unit a second (default: {}).",
                  jet_.speed)};
  Value<std::uint64_t> seed{
      in(OptionGroup::scene), "--seed", "N", parse_count,
      fmt::format("Of the numbers by which particles are off the lattice on which they leave the nozzle: another "
                  "number, other splashes (default: {}).",
                  jet_.seed)};
  Value<std::uint64_t> frames{
      in(OptionGroup::simulation), "--frames", "N", parse_positive_count,
      fmt::format("Frames to simulate; the first is one frame's time after the nozzle was opened (default: {}).",
                  kJetFrames)};
  Value<double> fps{in(OptionGroup::simulation), "--fps", "F", parse_positive,
                    fmt::format("Frames a second. A frame is as many steps as the fastest particle needs to move no "
                                "farther than 0.8 particle distances in each (default: {}).",
                                jet_.fps)};
  Value<double> gravity{
      in(OptionGroup::simulation), "--gravity", "G", parse_not_negative,
      fmt::format("Towards -z, in the tank's unit a second squared; the default is that of the Earth where "
                  "the unit is a decimetre (default: {}).",
                  jet_.gravity)};
  Value<double> viscosity{
      in(OptionGroup::simulation), "--viscosity", "C", parse_not_negative,
      fmt::format("How much velocities are evened out between neighbours in a step, 0 to 0.5 (default: {}).",
                  jet_.viscosity)};
  Value<std::uint64_t> iterations{
      in(OptionGroup::simulation), "--iterations", "N", parse_positive_count,
      fmt::format("Of the solver in a step; more of them compress the liquid less (default: {}).", jet_.iterations)};
  SequenceFlags sequence{*this, kJetExample,
                         "The extension, .ply, .npy or .xyz, chooses the format. '-' is stdout and needs --format.",
                         false};
  Value<particle_io::ParticleFileFormat> format{in(OptionGroup::output), "--format",
                                                "Format of the output, whatever the extension."};
  RunFlags run{*this};
};

}  // namespace isoextract::cli
