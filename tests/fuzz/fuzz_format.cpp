#include "fuzz/fuzz_format.hpp"

namespace isoextract::fuzz {

constinit const std::string_view kFormat = ISOEXTRACT_FUZZ_FORMAT;
constinit const std::string_view kExtension = ISOEXTRACT_FUZZ_EXTENSION;

}  // namespace isoextract::fuzz
