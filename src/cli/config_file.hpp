// Reads options of convert from a file: --config job.toml.
//
//   input = "sim_{:04}.vdb"      # or a list
//   iso = [0.15, 0.3]            # a repeatable option takes a list
//   dims = [48, 62, 42]          # a value of several numbers may be a list as well
//   cap = true                   # an option without a value
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "cli/command.hpp"
#include "cli/options/convert.hpp"

namespace isoextract::cli {

// Adds the file's options to `command`, which has parsed `arguments` with --config among them. Options and inputs of
// the command line replace those of the file, but the whole file is checked. Returns the arguments: the command's name
// if it is given, the words of the file that take effect, then the given options and inputs.
//
// Fails with ErrorCode::input if the file is unreadable or larger than 1 MiB. Fails with ErrorCode::usage if it is
// standard input ("-"), is not TOML, or has an unknown key or a value that the option refuses. Messages about the
// content begin with the file's name.
[[nodiscard]] Result<std::vector<std::string>> with_config(CommandOf<ConvertFlags>& command,
                                                           const std::vector<std::string>& arguments);

}  // namespace isoextract::cli
