// Where plug-ins read files: in child processes, so that a library that trusts its files cannot end this program, take
// more memory than it may, or change anything (plugin_worker.hpp, sandbox/worker.hpp).
#pragma once

#include <optional>
#include <span>

namespace isoextract::plugin_host {

// Called by main() before anything else: where this process was started to read files with a plug-in, it does so, and
// this gives the exit code. Programs that do not call it read in their own process.
[[nodiscard]] std::optional<int> run_as_plugin_reader(std::span<char* const> arguments);

// From now on plug-ins read in this process, for files that can be trusted. Called before the first file is read.
void read_in_process();

}  // namespace isoextract::plugin_host
