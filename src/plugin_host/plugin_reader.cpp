#include "plugin_host/plugin_reader.hpp"

#include "plugin_host/detail/plugin_worker.hpp"
#include "plugin_host/plugin_session.hpp"
#include "sandbox/program.hpp"

namespace isoextract::plugin_host {

std::optional<int> run_as_plugin_reader(std::span<char* const> arguments) {
  return sandbox::run_as_child(arguments, make_plugin_work);
}

void read_in_process() { read_files_in_process(); }

}  // namespace isoextract::plugin_host
