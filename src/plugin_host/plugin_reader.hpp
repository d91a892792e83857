// Plug-ins read files in child processes. So a library that does not validate its input cannot crash this program,
// exceed its memory, or change anything (detail/plugin_worker.hpp, sandbox/worker.hpp).
#pragma once

#include <optional>
#include <span>

namespace isoextract::plugin_host {

// main() calls this before anything else. If this process was started to read files with a plug-in, reads them and ends
// the process with code 0. Otherwise returns nothing. Programs without this call read files in their own process.
[[nodiscard]] std::optional<int> run_as_plugin_reader(std::span<char* const> arguments);

// Makes plug-ins read in this process from now on, for trusted files. Call before reading the first file.
void read_in_process();

}  // namespace isoextract::plugin_host
