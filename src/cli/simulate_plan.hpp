// From the options of `simulate` to plans: defaults applied, names of files found, combinations checked.
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

// One state that is written: after so many steps, to these files, in the order of what they hold.
struct SequenceFrame {
  std::uint64_t step = 0;
  std::vector<std::filesystem::path> files;
};

struct SequencePlan {
  std::uint64_t steps = 0;
  std::vector<SequenceFrame> frames;  // by step
  bool no_clobber = false;
  bool make_folders = false;
  MemoryBudget memory;
};

// What a sub-command brings along.
struct SequenceKind {
  std::string stem;                // of files in a folder, and {stem}
  std::string example;             // of -o
  std::string extension;           // of files in a folder
  std::vector<std::string> grids;  // a file each
  std::uint64_t steps = 0;         // the defaults
  std::uint64_t every = 1;
  std::uint64_t first = 0;  // the number of the first frame
};

// Every name once, and a place for the frame's number in it where there are several. Fails with ErrorCode::usage.
[[nodiscard]] Result<SequencePlan> plan_sequence(const SequenceFlags& flags, const SequenceKind& kind);

struct WaterPlan {
  simulate::TerrainOptions terrain;
  std::optional<double> level;
  std::optional<double> depth;
  bool default_scene = false;  // a source in the hills and a little water are to be added
  simulate::WaterOptions water;
  simulate::WaterContent what = simulate::WaterContent::water;
  volume_io::VolumeFileFormat format = volume_io::VolumeFileFormat::nrrd;
  glm::dvec3 spacing{1.0};
  SequencePlan sequence;
};
[[nodiscard]] Result<WaterPlan> plan_water(const WaterFlags& flags);

}  // namespace isoextract::cli
