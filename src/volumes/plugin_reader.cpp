#include "volumes/plugin_reader.hpp"

#include "sandbox/program.hpp"
#include "volumes/detail/plugin_visit.hpp"
#include "volumes/detail/plugin_worker.hpp"

namespace isoextract::volumes {

std::optional<int> run_as_plugin_reader(std::span<char* const> arguments) {
  return sandbox::run_if_child(arguments, make_plugin_work);
}

void read_in_process() { trust_files(); }

}  // namespace isoextract::volumes
