// The side of the child process: files read with a plug-in on behalf of the program, by its messages
// (plugin_messages.hpp).
#pragma once

#include <span>
#include <string>

#include "sandbox/program.hpp"

namespace isoextract::plugin_host {

// Opens the plug-in that `words` name: its function, its id and its file.
[[nodiscard]] sandbox::ChildWork make_plugin_work(std::span<const std::string> words);

}  // namespace isoextract::plugin_host
