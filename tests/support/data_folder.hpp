// Real volumes by others: the folder in ISOEXTRACT_DATA, or shared/data beside the checkout. Not part of the project.
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

// For files that include gtest: ends the test, saying so, where a file of the data folder is not there.
#define ISOEXTRACT_NEEDS_DATA(name)                                \
  if (!std::filesystem::exists(isoextract::test::data_file(name))) \
  GTEST_SKIP() << "no " << isoextract::test::data_file(name) << ": set ISOEXTRACT_DATA to the data folder"
