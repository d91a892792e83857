#include "gpu/detail/sample_format.hpp"

#include <algorithm>
#include <cctype>

namespace isoextract::gpu {

SampleFormat sample_format(field::SampleType type) {
  std::string define = "SAMPLE_" + std::string(field::sample_type_name(type));
  std::ranges::transform(define, define.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  switch (field::sample_size(type)) {
    case 1: return {GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, define};
    case 2: return {GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT, define};
    case 4: return {GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, define};
    default: return {GL_RG32UI, GL_RG_INTEGER, GL_UNSIGNED_INT, define};
  }
}

}  // namespace isoextract::gpu
