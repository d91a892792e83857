#include "plugin_host/plugin_reader.hpp"

#include "plugin_host/detail/plugin_worker.hpp"
#include "plugin_host/plugin_visit.hpp"
#include "sandbox/program.hpp"

namespace isoextract::plugin_host {

std::optional<int> run_as_plugin_reader(std::span<char* const> arguments) {
  return sandbox::run_if_child(arguments, make_plugin_work);
}

void read_in_process() { trust_files(); }

}  // namespace isoextract::plugin_host
