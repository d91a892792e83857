// The program's version, from CMake's project(). Not a constant of the header: another version compiles one file anew.
#pragma once

#include <string_view>

namespace isoextract {

[[nodiscard]] std::string_view version();    // "0.1.0"
[[nodiscard]] std::string_view generator();  // "isoextract 0.1.0": what files say made them

}  // namespace isoextract
