// The child process's side: reads files with a plug-in as the program's messages ask (plugin_messages.hpp).
#pragma once

#include <span>
#include <string>

#include "sandbox/program.hpp"

namespace isoextract::plugin_host {

// Opens the plug-in given by `words`: exported function, id and file. If that fails, `run` is empty and `greeting` has
// the reason.
[[nodiscard]] sandbox::ChildWork make_plugin_work(std::span<const std::string> words);

}  // namespace isoextract::plugin_host
