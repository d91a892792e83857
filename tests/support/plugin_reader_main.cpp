// The test program starts itself as the child process in which plug-ins read files, as isoextract does.
#include <cstddef>

#include <gtest/gtest.h>

#include "plugin_host/plugin_reader.hpp"

int main(int argc, char** argv) {
  if (const auto code = isoextract::plugin_host::run_as_plugin_reader({argv, static_cast<std::size_t>(argc)}))
    return *code;
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
