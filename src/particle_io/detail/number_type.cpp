#include "particle_io/detail/number_type.hpp"

#include <array>

namespace isoextract::particle_io {

std::size_t number_size(NumberType type) {
  return visit_number_type(type, []<class T>(std::type_identity<T>) { return sizeof(T); });
}

std::string_view number_name(NumberType type) {
  constexpr std::array<std::string_view, 11> kNames{"u8",  "i8",  "u16", "i16", "u32", "i32",
                                                    "u64", "i64", "f16", "f32", "f64"};
  return kNames[static_cast<std::size_t>(type)];
}

}  // namespace isoextract::particle_io
