// Options of convert from a file: --config job.toml.
//
//   input = "sim_{:04}.vdb"      # or a list
//   iso = [0.15, 0.3]            # an option that may be given several times takes a list
//   dims = [48, 62, 42]          # numbers that are one value with commas may be a list as well
//   cap = true                   # one without a value
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

struct ConfiguredLine {
  std::unique_ptr<CommandLine> line;
  std::vector<std::string> arguments;  // those that were given, and before them what the file adds
};

// `line` was parsed from `arguments` and has --config. What the command line has itself, the inputs among it, is not
// taken from the file; all of the file is checked all the same. Fails with ErrorCode::input where the file cannot be
// read, and with ErrorCode::usage where it is not TOML, has a key that is no option, or a value that its option does
// not take; messages begin with its name.
[[nodiscard]] Result<ConfiguredLine> with_config(const CommandLine& line, const std::vector<std::string>& arguments);

}  // namespace isoextract::cli
