#include "base/version.hpp"

namespace isoextract {

std::string_view version() { return ISOEXTRACT_VERSION; }
std::string_view generator() { return "isoextract " ISOEXTRACT_VERSION; }

}  // namespace isoextract
