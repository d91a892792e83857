// Real volumes from other sources, which are not part of the project: the folder in ISOEXTRACT_DATA, or shared/data
// beside the checkout.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace isoextract::test {

inline std::filesystem::path data_file(const std::string& name) {
  if (const char* folder = std::getenv("ISOEXTRACT_DATA")) return std::filesystem::path(folder) / name;
  return std::filesystem::path(ISOEXTRACT_SOURCE_DIR) / ".." / "shared" / "data" / name;
}

}  // namespace isoextract::test

// Skips the test with a message if a file of the data folder is missing. For sources that include gtest.
#define ISOEXTRACT_NEEDS_DATA(name)                                \
  if (!std::filesystem::exists(isoextract::test::data_file(name))) \
  GTEST_SKIP() << "no " << isoextract::test::data_file(name) << ": set ISOEXTRACT_DATA to the data folder"
