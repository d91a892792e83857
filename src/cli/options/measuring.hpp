// The options of the commands that look at inputs and measure methods: info, bench and stability.
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

  InputFlags input{*this,
                   {"INPUT...", "The volumes or particles to look at, or patterns and folders of a sequence, each"}};
  FramesOption frames{in(OptionGroup::input), "Frames of a sequence to look at, such as 1-240x20 (default: all)."};
  ParticleFlags particles{*this};
  JsonFlag json{in(OptionGroup::output), "Report as JSON, an array with one entry an input."};
  RunFlags run{*this};
};

// Those that bench takes by itself, as one word.
[[nodiscard]] std::string following_method_ids();

struct BenchFlags : OptionSet {
  BenchFlags();

  InputFlags input{*this,
                   {"INPUT...",
                    "What to extract from (default: demo:torus), or gpu-threads for the cost of a GPU's threads "
                    "(Timokhin and Mikhaylyuk), each"}};
  Value<std::vector<int>> sizes{in(OptionGroup::input), "--sizes", "N,N,...", parse_demo_sizes,
                                "Samples along each axis of demo fields (default: 32,64,128,256)."};
  Value<std::vector<int>> coarser{
      in(OptionGroup::input),
      "--coarser",
      "F,F,...",
      parse_coarse_factors,
      "Of files besides the data themselves: one sample, their mean, for each F^3; powers of two (default: 2,4,8 "
      "where that leaves 8 samples along each axis). The data's own surface is the truth.",
      About::extraction};
  Value<double> iso{in(OptionGroup::surface),
                    "--iso",
                    "V",
                    parse_number,
                    "The value whose surface is extracted (default: the demo field's own). Files need it.",
                    About::extraction};
  Value<std::vector<extract::Method>> methods{
      in(OptionGroup::surface),
      "--methods",
      "M,M,...",
      parse_methods,
      fmt::format("Of {} (default: {}).", fmt::join(extract::method_ids(), ", "), following_method_ids()),
      About::extraction};
  NanOption nan{in(OptionGroup::surface)};
  Value<std::string> csv{in(OptionGroup::output), "--csv", "FILE", parse_text, "Write the rows of the table as CSV.",
                         About::extraction};
  Value<std::string> json{in(OptionGroup::output), "--json", "FILE", parse_text, "Write everything as JSON."};
  Value<std::string> plot{
      in(OptionGroup::output), "--plot", "FILE", parse_text, "Draw error over run time with gnuplot, as .svg or .png.",
      About::extraction};
  BackendsOption backends{in(OptionGroup::run), "cpu, and gpu where there is one that is not software"};
  DeviceFlags device{*this};
  Value<std::vector<int>> threads{in(OptionGroup::run),
                                  "--threads",
                                  "N,N,...",
                                  parse_thread_counts,
                                  "Numbers of threads to compare, none above that of the machine (default: 1 and all).",
                                  About::extraction};
  Value<int> repeats{in(OptionGroup::run), "--repeats", "N", parse_repeats,
                     "Times to run each setting after a warm-up; the median counts (default: 5)."};
  RunFlags run{*this, RunFlags::Taken::verbosity};
};

struct StabilityFlags : OptionSet {
  StabilityFlags();

  Values<std::string> cases{in(OptionGroup::input), "--case", "NAME", parse_text,
                            "Run this case only; several times for several cases (default: all)."};  // all if empty
  Flag list{in(OptionGroup::output), "--list", "List the cases, what is extreme about each, and run none."};
  JsonFlag json{in(OptionGroup::output)};
  BackendsOption backends{in(OptionGroup::run), "cpu, and gpu where there is one"};
  DeviceFlags device{*this};
  RunFlags run{*this};
};

}  // namespace isoextract::cli
