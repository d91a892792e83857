#include "zarr_elements.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

namespace isoextract_zarr {
namespace {

template <std::size_t kSize>
std::size_t copy_elements(const std::byte* from, std::ptrdiff_t from_step, std::byte* to, std::ptrdiff_t to_step,
                          std::size_t count) {
  constexpr auto kStep = static_cast<std::ptrdiff_t>(kSize);
  if (from_step == kStep && to_step == kStep) {
    std::memcpy(to, from, count * kSize);
    return count;
  }
  // Most fill values are 0.
  if (from_step == 0 && to_step == kStep &&
      std::all_of(from, from + kSize, [](std::byte b) { return b == std::byte{}; })) {
    std::memset(to, 0, count * kSize);
    return count;
  }
  for (std::size_t i = 0; i < count; ++i, from += from_step, to += to_step) std::memcpy(to, from, kSize);
  return count;
}

// Converts 64-bit integers to doubles; stops at the first inexact one. Doubles represent all integers up to 2^53, and
// larger ones with enough trailing zero bits.
template <class T>
std::size_t widen_elements(const std::byte* from, std::ptrdiff_t from_step, std::byte* to, std::ptrdiff_t to_step,
                           std::size_t count) {
  constexpr double kEnd = std::is_signed_v<T> ? 0x1p63 : 0x1p64;
  for (std::size_t i = 0; i < count; ++i, from += from_step, to += to_step) {
    T value{};
    std::memcpy(&value, from, sizeof value);
    const auto sample = static_cast<double>(value);
    if (sample >= kEnd || static_cast<T>(sample) != value) return i;
    std::memcpy(to, &sample, sizeof sample);
  }
  return count;
}

// T: type of an element's numbers; Out: type of the length.
template <class T, class Out>
CopyRow length_row(std::size_t numbers, double slope, double intercept) {
  return
      [=](const std::byte* from, std::ptrdiff_t from_step, std::byte* to, std::ptrdiff_t to_step, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i, from += from_step, to += to_step) {
          double sum = 0;
          for (std::size_t k = 0; k < numbers; ++k) {
            T value{};
            std::memcpy(&value, from + k * sizeof value, sizeof value);
            const double scaled = slope * static_cast<double>(value) + intercept;
            sum += scaled * scaled;
          }
          const auto length = static_cast<Out>(std::sqrt(sum));
          std::memcpy(to, &length, sizeof length);
        }
        return count;
      };
}

CopyRow lengths_of(const DataType& type, const Conversion& how) {
  const std::size_t numbers = type.kind == DataType::Kind::complex ? 2 : 1;
  const double slope = how.slope;
  const double intercept = how.intercept;
  const bool is_float = type.kind == DataType::Kind::floating || type.kind == DataType::Kind::complex;
  const bool is_signed = type.kind == DataType::Kind::signed_integer;
  switch (type.number()) {
    case 1:
      return is_signed ? length_row<std::int8_t, float>(numbers, slope, intercept)
                       : length_row<std::uint8_t, float>(numbers, slope, intercept);
    case 2:
      if (is_float) throw ReadError("lengths of half floats are not supported");
      return is_signed ? length_row<std::int16_t, float>(numbers, slope, intercept)
                       : length_row<std::uint16_t, float>(numbers, slope, intercept);
    case 4:
      if (is_float) return length_row<float, float>(numbers, slope, intercept);
      return is_signed ? length_row<std::int32_t, double>(numbers, slope, intercept)
                       : length_row<std::uint32_t, double>(numbers, slope, intercept);
    default:
      if (is_float) return length_row<double, double>(numbers, slope, intercept);
      return is_signed ? length_row<std::int64_t, double>(numbers, slope, intercept)
                       : length_row<std::uint64_t, double>(numbers, slope, intercept);
  }
}

bool is_wide_integer(const DataType& type) {
  constexpr std::uint64_t kWide = 8;
  return type.size == kWide && type.kind != DataType::Kind::floating && type.kind != DataType::Kind::complex;
}

}  // namespace

CopyRow copy_row_of(const DataType& type, const Conversion& conversion) {
  if (conversion.component == ISOEXTRACT_COMPONENT_LENGTH) return lengths_of(type, conversion);
  if (is_wide_integer(type)) {
    return type.kind == DataType::Kind::signed_integer ? widen_elements<std::int64_t> : widen_elements<std::uint64_t>;
  }
  switch (type.number()) {
    case 1: return copy_elements<1>;
    case 2: return copy_elements<2>;
    case 4: return copy_elements<4>;
    default: return copy_elements<8>;
  }
}

std::uint64_t sample_bytes_of(const DataType& type, const Conversion& conversion) {
  isoextract_plugin::Grid grid;
  grid.sample_type = sample_type_of(type);
  isoextract_volume_selection selection{};
  selection.component = conversion.component;
  return isoextract_plugin::sample_size(isoextract_plugin::selected_type(grid, selection));
}

std::int32_t sample_type_of(const DataType& type) {
  const bool is_signed = type.kind == DataType::Kind::signed_integer;
  switch (type.kind) {
    case DataType::Kind::floating:
    case DataType::Kind::complex:
      if (type.number() == 2) return ISOEXTRACT_F16;
      return type.number() == 4 ? ISOEXTRACT_F32 : ISOEXTRACT_F64;
    case DataType::Kind::unsigned_integer:
    case DataType::Kind::signed_integer:
      switch (type.size) {
        case 1: return is_signed ? ISOEXTRACT_I8 : ISOEXTRACT_U8;
        case 2: return is_signed ? ISOEXTRACT_I16 : ISOEXTRACT_U16;
        case 4: return is_signed ? ISOEXTRACT_I32 : ISOEXTRACT_U32;
        default: return ISOEXTRACT_F64;
      }
    case DataType::Kind::other: break;
  }
  return ISOEXTRACT_NOT_SCALAR;
}

}  // namespace isoextract_zarr
