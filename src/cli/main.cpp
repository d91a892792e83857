#include <cstddef>

#include "cli/program.hpp"
#include "plugin_host/plugin_reader.hpp"

int main(int argc, char** argv) {
  if (const auto code = isoextract::plugin_host::run_as_plugin_reader({argv, static_cast<std::size_t>(argc)}))
    return *code;
  return isoextract::cli::run(argc, argv);
}
