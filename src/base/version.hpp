// The program's version, from CMake's project().
#pragma once

#include <string_view>

namespace isoextract {

inline constexpr std::string_view kVersion = ISOEXTRACT_VERSION;
inline constexpr std::string_view kGenerator = "isoextract " ISOEXTRACT_VERSION;  // what files say made them

}  // namespace isoextract
