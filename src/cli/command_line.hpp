// From the words of the command line to a filled CommandLine, or to a message that says which word is wrong.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

enum class Request {
  convert,
  info,
  verify,
  compare,
  check,
  render,
  bench,
  stability,
  merge,
  devices,
  water,
  jet,
  help,
  generate,
  help_flag,
  version_flag
};

struct Parsed {
  Request request = Request::convert;
  const CLI::App* command = nullptr;  // whose help is asked for by help_flag; the program itself has one too
};

// The command that the first of the words, without the program's name, is about: convert where it names none.
[[nodiscard]] const CLI::App& command_of(const CommandLine& line, const std::vector<std::string>& arguments);
// Returns the command within that one where it has several, such as `simulate water`, and that one where they name
// none.
[[nodiscard]] const CLI::App& innermost_command_of(const CommandLine& line, const std::vector<std::string>& arguments);

// `arguments` are without the program's name and not empty. Where the first is no command and no request for help or
// version, "convert" stands before it.
[[nodiscard]] Result<Parsed> parse_command_line(CommandLine& line, std::vector<std::string> arguments);

}  // namespace isoextract::cli
