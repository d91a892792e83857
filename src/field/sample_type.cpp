#include "field/sample_type.hpp"

#include <array>

namespace isoextract::field {
namespace {

constexpr std::array<std::pair<SampleType, std::string_view>, 9> kNames{{{SampleType::u8, "u8"},
                                                                         {SampleType::i8, "i8"},
                                                                         {SampleType::u16, "u16"},
                                                                         {SampleType::i16, "i16"},
                                                                         {SampleType::u32, "u32"},
                                                                         {SampleType::i32, "i32"},
                                                                         {SampleType::f16, "f16"},
                                                                         {SampleType::f32, "f32"},
                                                                         {SampleType::f64, "f64"}}};

}  // namespace

std::size_t sample_size(SampleType type) {
  return visit_sample_type(type, []<class T>(std::type_identity<T>) { return sizeof(T); });
}

std::string_view sample_type_name(SampleType type) {
  for (const auto& [candidate, name] : kNames) {
    if (candidate == type) return name;
  }
  return "";
}

std::optional<SampleType> parse_sample_type(std::string_view name) {
  for (const auto& [type, candidate] : kNames) {
    if (candidate == name) return type;
  }
  return std::nullopt;
}

}  // namespace isoextract::field
