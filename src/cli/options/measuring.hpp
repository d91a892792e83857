// The options of the commands that describe inputs and measure methods: info, bench and stability.
#pragma once

#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/option.hpp"
#include "cli/options/frames.hpp"
#include "cli/options/input.hpp"
#include "cli/options/run.hpp"
#include "cli/options/surface.hpp"
#include "cli/values.hpp"

namespace isoextract::cli {

struct InfoFlags : OptionSet {
  InfoFlags();

  InputFlags input{*this, {"INPUT...", "Volumes or particles; patterns or folders of sequences"}};
  Flag masks{
      in(OptionGroup::input), "--masks",
      "Make one label map of masks, one file each. Inputs are files or one folder, all on one grid: samples are 0 "
      "outside and one other value inside. Each mask becomes a mesh named after its file. Neighbors meet without "
      "gaps; overlapping masks keep all their voxels."};
  FramesOption frames{in(OptionGroup::input), "Frames of a sequence to read, such as 1-240x20. Default: all."};
  ParticleFlags particles{*this};
  JsonFlag json{in(OptionGroup::output),
                "Report as JSON: an array with one entry for each input. A sequence and --masks have one entry."};
  RunFlags run{*this};
};

// Returns the ids of bench's default methods, separated by commas: the methods that follow the interpolant.
[[nodiscard]] std::string following_method_ids();

struct BenchFlags : OptionSet {
  BenchFlags();

  InputFlags input{*this,
                   {"INPUT...",
                    "Volumes (default: demo:torus). The word gpu-threads measures the cost of a GPU's threads "
                    "(Timokhin and Mikhaylyuk)"}};
  Value<std::vector<int>> sizes{in(OptionGroup::input), "--sizes", "N,N,...", parse_demo_sizes,
                                "Sizes of demo fields (default: 32,64,128,256). Samples along each axis."};
  Value<std::vector<int>> coarser{
      in(OptionGroup::input),
      "--coarser",
      "F,F,...",
      parse_coarse_factors,
      "Factors by which files are made coarser. Powers of two: F replaces F^3 samples by their mean. The surface of "
      "the full data is the truth. Default: 2,4,8 as far as 8 samples remain along each axis.",
      About::extraction};
  Value<double> iso{in(OptionGroup::surface),
                    "--iso",
                    "V",
                    parse_number,
                    "Iso value of the surface; files need one. Default: the demo field's own.",
                    About::extraction};
  Value<std::vector<extract::Method>> methods{
      in(OptionGroup::surface),
      "--methods",
      "M,M,...",
      parse_methods,
      fmt::format("Methods to compare (default: {1}). Any of {0}.", fmt::join(extract::method_ids(), ", "),
                  following_method_ids()),
      About::extraction};
  NanOption nan{in(OptionGroup::surface)};
  Value<std::string> csv{in(OptionGroup::output),   "--csv",          "FILE", parse_text,
                         "Write the table as CSV.", About::extraction};
  Value<std::string> json{in(OptionGroup::output), "--json", "FILE", parse_text, "Write all results as JSON."};
  Value<std::string> plot{in(OptionGroup::output),
                          "--plot",
                          "FILE",
                          parse_text,
                          "Plot error over run time, as .svg or .png. gnuplot draws it.",
                          About::extraction};
  BackendsOption backends{in(OptionGroup::run), "cpu, and gpu where there is one that is not software"};
  DeviceFlags device{*this};
  Value<std::vector<int>> threads{in(OptionGroup::run),
                                  "--threads",
                                  "N,N,...",
                                  parse_thread_counts,
                                  "Numbers of threads to compare (default: 1 and all). Each at most the number of the "
                                  "machine's threads.",
                                  About::extraction};
  Value<int> repeats{in(OptionGroup::run), "--repeats", "N", parse_repeats,
                     "Runs of each setting; the median counts (default: 5). A warm-up comes first."};
  RunFlags run{*this, RunFlags::Taken::verbosity};
};

struct StabilityFlags : OptionSet {
  StabilityFlags();

  Values<std::string> cases{in(OptionGroup::input), "--case", "NAME", parse_text,
                            "Run this case only (default: all). Several times for several cases."};  // all if empty
  Flag list{in(OptionGroup::output), "--list", "List the cases with their extreme property. Runs none."};
  JsonFlag json{in(OptionGroup::output)};
  BackendsOption backends{in(OptionGroup::run), "cpu, and gpu where there is one"};
  DeviceFlags device{*this};
  RunFlags run{*this};
};

}  // namespace isoextract::cli
