// Makes plans from the options of `simulate`: applies defaults, names files, checks combinations.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "base/memory_budget.hpp"
#include "cli/options.hpp"
#include "simulate/terrain.hpp"

namespace isoextract::cli {

// A state to write: the step, and the files in the order of SequenceKind::grids. For a jet, `step` counts frames, which
// are 1 / fps seconds apart, not steps of the solver.
struct SequenceFrame {
  std::uint64_t step = 0;
  std::vector<std::filesystem::path> files;
};

struct SequencePlan {
  std::uint64_t steps = 0;            // the step of the last frame
  std::vector<SequenceFrame> frames;  // in ascending order of steps
  bool no_clobber = false;
  bool make_folders = false;
  MemoryBudget memory;
};

// The properties of a sub-command.
struct SequenceKind {
  std::string stem;                // stem of files in a folder, and the value of {stem}
  std::string example;             // an example of -o
  std::string extension;           // extension of files in a folder
  std::vector<std::string> grids;  // one file per grid; one empty name: a single file, and -o must not have {grid}
  std::uint64_t steps = 0;         // default number of steps
  std::uint64_t every = 1;         // default number of steps from frame to frame
  std::uint64_t first = 0;         // the number of the first frame; its step is first * every
};

// Plans the frames and their files. A folder, or a file name with a placeholder for the frame number, gets all frames;
// any other file name gets only the last step. Fails with ErrorCode::usage if -o is missing or unusable, if names
// repeat, if --every is given for a single step, if the steps are no multiple of --every, or for too many frames.
[[nodiscard]] Result<SequencePlan> plan_sequence(const SequenceFlags& flags, const SequenceKind& kind);

struct WaterPlan {
  simulate::TerrainOptions terrain;
  std::optional<double> level;  // height of a lake's surface above the floor of the world, in cells
  std::optional<double> depth;  // depth of water added to each cell, in cells
  bool default_scene = false;   // adds a spring in the hills and a little water
  simulate::WaterOptions water;
  simulate::WaterOutput what = simulate::WaterOutput::water;
  volume_io::VolumeFileFormat format = volume_io::VolumeFileFormat::nrrd;
  glm::dvec3 spacing{1.0};
  SequencePlan sequence;
};
[[nodiscard]] Result<WaterPlan> plan_water(const WaterFlags& flags);

}  // namespace isoextract::cli
