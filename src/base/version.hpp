// The program's version, from CMake's project(). Functions, not constants: a new version recompiles one file only.
#pragma once

#include <string_view>

namespace isoextract {

[[nodiscard]] std::string_view version();    // "0.2.0"
[[nodiscard]] std::string_view generator();  // "isoextract 0.2.0": the generator that output files name

}  // namespace isoextract
