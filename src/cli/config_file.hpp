// Options of convert from a file: --config job.toml.
//
//   input = "sim_{:04}.vdb"      # or a list
//   iso = [0.15, 0.3]            # an option that may be given several times takes a list
//   dims = [48, 62, 42]          # numbers that are one value with commas may be a list as well
//   cap = true                   # one without a value
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "cli/command.hpp"
#include "cli/options/convert.hpp"

namespace isoextract::cli {

// `command` has read `arguments`, with --config among them. Gives it the options of the file as well, and returns the
// arguments with what the file adds before those that were given. What the command line has itself, the inputs among
// it, is not taken from the file; all of the file is checked all the same. Fails with ErrorCode::input where the file
// cannot be read, and with ErrorCode::usage where it is not TOML, has a key that is no option, or a value that its
// option does not take; messages begin with its name.
[[nodiscard]] Result<std::vector<std::string>> with_config(CommandOf<ConvertFlags>& command,
                                                           const std::vector<std::string>& arguments);

}  // namespace isoextract::cli
