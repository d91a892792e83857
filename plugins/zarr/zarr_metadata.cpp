#include "zarr_metadata.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>

namespace isoextract_zarr {
namespace {

constexpr std::size_t kMostAxes = 32;

struct TypeName {
  std::string_view v2;  // after the byte order
  std::string_view v3;
  DataType::Kind kind;
  std::uint64_t size;
};

constexpr std::array kTypes{TypeName{"b1", "bool", DataType::Kind::unsigned_integer, 1},
                            TypeName{"u1", "uint8", DataType::Kind::unsigned_integer, 1},
                            TypeName{"u2", "uint16", DataType::Kind::unsigned_integer, 2},
                            TypeName{"u4", "uint32", DataType::Kind::unsigned_integer, 4},
                            TypeName{"u8", "uint64", DataType::Kind::unsigned_integer, 8},
                            TypeName{"i1", "int8", DataType::Kind::signed_integer, 1},
                            TypeName{"i2", "int16", DataType::Kind::signed_integer, 2},
                            TypeName{"i4", "int32", DataType::Kind::signed_integer, 4},
                            TypeName{"i8", "int64", DataType::Kind::signed_integer, 8},
                            TypeName{"f2", "float16", DataType::Kind::floating, 2},
                            TypeName{"f4", "float32", DataType::Kind::floating, 4},
                            TypeName{"f8", "float64", DataType::Kind::floating, 8},
                            TypeName{"c8", "complex64", DataType::Kind::complex, 8},
                            TypeName{"c16", "complex128", DataType::Kind::complex, 16}};

std::string shown_json(const Json& value) { return shown(value.dump(-1, ' ', false, Json::error_handler_t::replace)); }

DataType type_called(std::string_view name, std::string_view TypeName::*member_name, const Json& whole) {
  const auto found = std::ranges::find(kTypes, name, member_name);
  if (found != kTypes.end()) return {found->kind, found->size, std::string(found->v3)};
  return {DataType::Kind::other, 0, whole.is_string() ? shown(whole.get_ref<const std::string&>()) : "structure"};
}

// Returns the bits of a half float that has this value, rounded to the nearest (IEEE 754).
std::uint16_t half_of(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  const auto sign = static_cast<std::uint16_t>((bits >> 48) & 0x8000);
  constexpr std::uint16_t kInfinity = 0x7c00;
  if (std::isnan(value)) return sign | 0x7e00;
  constexpr double kRoundsToInfinity = 65520;
  const double size = std::abs(value);
  if (size >= kRoundsToInfinity) return sign | kInfinity;
  constexpr double kSmallestNormal = 0x1p-14;
  if (size < kSmallestNormal) return sign | static_cast<std::uint16_t>(std::nearbyint(size * 0x1p24));
  const int exponent = std::ilogb(size);
  const auto mantissa = static_cast<int>(std::nearbyint(std::ldexp(size, 10 - exponent)));
  return sign | static_cast<std::uint16_t>(((exponent + 14) << 10) + mantissa);
}

[[noreturn]] void bad_fill(const Json& fill, const DataType& type) {
  throw ReadError(fmt::format("expected a fill value of the type {}, found {}", type.name, shown_json(fill)));
}

template <class T>
void put(Bytes& bytes, T value) {
  const auto* first = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), first, first + sizeof value);
}

template <class T>
void put_integer(Bytes& bytes, const Json& fill, const DataType& type) {
  if (fill.is_boolean()) return put(bytes, static_cast<T>(fill.get<bool>() ? 1 : 0));
  if (fill.is_number_unsigned()) {
    const auto value = fill.get<std::uint64_t>();
    if (value > static_cast<std::uint64_t>(std::numeric_limits<T>::max())) bad_fill(fill, type);
    return put(bytes, static_cast<T>(value));
  }
  if (fill.is_number_integer()) {
    const auto value = fill.get<std::int64_t>();  // negative
    if (!std::is_signed_v<T> || value < static_cast<std::int64_t>(std::numeric_limits<T>::min())) bad_fill(fill, type);
    return put(bytes, static_cast<T>(value));
  }
  // Accepts 0.0 for 0, which some writers use.
  const double value = fill.is_number_float() ? fill.get<double>() : 0.5;
  if (value != std::trunc(value) || std::abs(value) > 0x1p53 || (value < 0 && !std::is_signed_v<T>)) {
    bad_fill(fill, type);
  }
  if (std::abs(value) > static_cast<double>(std::numeric_limits<T>::max())) bad_fill(fill, type);
  put(bytes, static_cast<T>(value));
}

// Accepts a number, "NaN", "Infinity", "-Infinity", or the bits of the number as "0x...".
void put_float(Bytes& bytes, const Json& fill, const DataType& type) {
  const std::uint64_t size = type.number();
  double value = 0;
  const std::string text = text_of(fill);
  if (fill.is_number()) {
    value = fill.get<double>();
  } else if (text == "NaN") {
    value = std::numeric_limits<double>::quiet_NaN();
  } else if (text == "Infinity" || text == "-Infinity") {
    value = text.front() == '-' ? -std::numeric_limits<double>::infinity() : std::numeric_limits<double>::infinity();
  } else {
    std::uint64_t bits = 0;
    const char* const end = text.data() + text.size();
    if (text.size() != 2 + 2 * size || !text.starts_with("0x") ||
        std::from_chars(text.data() + 2, end, bits, 16).ptr != end) {
      bad_fill(fill, type);
    }
    if (size == 2) return put(bytes, static_cast<std::uint16_t>(bits));
    if (size == 4) return put(bytes, static_cast<std::uint32_t>(bits));
    return put(bytes, bits);
  }
  if (size == 2) return put(bytes, half_of(value));
  if (size == 4) return put(bytes, static_cast<float>(value));
  put(bytes, value);
}

void put_number(Bytes& bytes, const Json& fill, const DataType& type) {
  if (type.kind == DataType::Kind::floating || type.kind == DataType::Kind::complex)
    return put_float(bytes, fill, type);
  const bool is_signed = type.kind == DataType::Kind::signed_integer;
  switch (type.size) {
    case 1:
      return is_signed ? put_integer<std::int8_t>(bytes, fill, type) : put_integer<std::uint8_t>(bytes, fill, type);
    case 2:
      return is_signed ? put_integer<std::int16_t>(bytes, fill, type) : put_integer<std::uint16_t>(bytes, fill, type);
    case 4:
      return is_signed ? put_integer<std::int32_t>(bytes, fill, type) : put_integer<std::uint32_t>(bytes, fill, type);
    default:
      return is_signed ? put_integer<std::int64_t>(bytes, fill, type) : put_integer<std::uint64_t>(bytes, fill, type);
  }
}

// Returns the bytes of the fill value. A null one leaves missing chunks undefined: 0 as in zarr-python and zarrita.
Bytes fill_of(const Json& fill, const DataType& type) {
  if (type.kind == DataType::Kind::other) return {};
  if (fill.is_null()) return Bytes(type.size);
  Bytes bytes;
  if (type.kind == DataType::Kind::complex) {
    if (fill.is_array() && fill.size() == 2) {
      for (const Json& part : fill) put_number(bytes, part, type);
    } else {
      put_number(bytes, fill, type);
      bytes.resize(type.size);
    }
  } else {
    put_number(bytes, fill, type);
  }
  return bytes;
}

void check_shapes(const ArrayMetadata& array) {
  if (array.shape.size() > kMostAxes) {
    throw ReadError(fmt::format("expected at most {} axes, found {}", kMostAxes, array.shape.size()));
  }
  if (array.chunk.size() != array.shape.size()) {
    throw ReadError(fmt::format("expected chunks of {} axes, found {}", array.shape.size(), array.chunk.size()));
  }
  if (std::ranges::find(array.chunk, 0U) != array.chunk.end()) throw ReadError("expected chunks, found empty ones");
  static_cast<void>(product_of(array.shape, std::max<std::uint64_t>(array.type.size, 1)));
  static_cast<void>(product_of(array.chunk, std::max<std::uint64_t>(array.type.size, 1)));
}

std::vector<std::string> names_of(const Json& value, std::size_t axes) {
  std::vector<std::string> names;
  if (!value.is_array() || value.size() != axes) return names;
  for (const Json& name : value) names.push_back(text_of(name));
  return names;
}

}  // namespace

const Json& member(const Json& object, const char* key) {
  static const Json kNull;
  if (!object.is_object()) return kNull;
  const auto found = object.find(key);
  return found == object.end() ? kNull : *found;
}

std::string text_of(const Json& value) { return value.is_string() ? value.get<std::string>() : std::string(); }

std::vector<std::uint64_t> counts_of(const Json& value, const char* what) {
  std::vector<std::uint64_t> counts;
  bool is_valid = value.is_array();
  for (std::size_t i = 0; is_valid && i < value.size(); ++i) {
    is_valid = value[i].is_number_unsigned();
    if (is_valid) counts.push_back(value[i].get<std::uint64_t>());
  }
  if (!is_valid) {
    throw ReadError(fmt::format("expected {} as an array of integers, found {}", what, shown_json(value)));
  }
  return counts;
}

std::optional<std::vector<double>> numbers_of(const Json& value, std::size_t count) {
  if (!value.is_array() || value.size() != count) return std::nullopt;
  std::vector<double> numbers;
  for (const Json& number : value) {
    if (!number.is_number() || !std::isfinite(number.get<double>())) return std::nullopt;
    numbers.push_back(number.get<double>());
  }
  return numbers;
}

std::uint64_t product_of(const std::vector<std::uint64_t>& factors, std::uint64_t first) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 63;
  std::uint64_t product = first;
  for (const std::uint64_t factor : factors) {
    if (factor > 0 && product >= kMost / factor)
      throw ReadError("its shape has more samples than any machine can hold");
    product *= factor;
  }
  return product;
}

std::string ArrayMetadata::chunk_key(const std::vector<std::uint64_t>& chunk_index) const {
  std::string key = chunk_prefix;
  for (const std::uint64_t index : chunk_index) {
    if (!key.empty()) key += separator;
    key += std::to_string(index);
  }
  // An array without axes has one chunk.
  return key.empty() ? "0" : key;
}

ArrayMetadata parse_v2_array(const Json& metadata, const Json& attributes) {
  if (member(metadata, "zarr_format") != 2) {
    throw ReadError(fmt::format("expected zarr_format 2, found {}", shown_json(member(metadata, "zarr_format"))));
  }
  ArrayMetadata array;
  array.shape = counts_of(member(metadata, "shape"), "the shape");
  array.chunk = counts_of(member(metadata, "chunks"), "the shape of chunks");
  const Json& type = member(metadata, "dtype");
  const std::string text = text_of(type);
  const bool has_order = !text.empty() && std::string_view("<>|=").find(text.front()) != std::string_view::npos;
  array.type = type_called(has_order ? std::string_view(text).substr(1) : std::string_view(text), &TypeName::v2, type);
  array.pipeline.is_big_endian = has_order && text.front() == '>';
  if (array.type.kind == DataType::Kind::other) array.unsupported_feature = "elements of the type " + array.type.name;
  check_shapes(array);
  array.fill = fill_of(member(metadata, "fill_value"), array.type);
  array.separator = text_of(member(metadata, "dimension_separator")) == "/" ? '/' : '.';
  array.dimension_names = names_of(member(attributes, "_ARRAY_DIMENSIONS"), array.shape.size());
  if (array.unsupported_feature.empty()) set_v2_codecs(metadata, array);
  return array;
}

ArrayMetadata parse_v3_array(const Json& metadata) {
  ArrayMetadata array;
  array.shape = counts_of(member(metadata, "shape"), "the shape");
  const Json& grid = member(metadata, "chunk_grid");
  if (member(grid, "name") != "regular") {
    throw ReadError(fmt::format("expected a regular chunk grid, found {}", shown_json(member(grid, "name"))));
  }
  array.chunk = counts_of(member(member(grid, "configuration"), "chunk_shape"), "the shape of chunks");
  const Json& type = member(metadata, "data_type");
  array.type = type_called(text_of(type), &TypeName::v3, type);
  if (array.type.kind == DataType::Kind::other) array.unsupported_feature = "elements of the type " + array.type.name;
  check_shapes(array);
  array.fill = fill_of(member(metadata, "fill_value"), array.type);
  const Json& encoding = member(metadata, "chunk_key_encoding");
  const std::string separator = text_of(member(member(encoding, "configuration"), "separator"));
  if (member(encoding, "name") == "default") {
    array.chunk_prefix = "c";
    array.separator = separator == "." ? '.' : '/';
  } else if (member(encoding, "name") == "v2") {
    array.separator = separator == "/" ? '/' : '.';
  } else if (array.unsupported_feature.empty()) {
    array.unsupported_feature = "chunk keys in the encoding " + shown_json(member(encoding, "name"));
  }
  array.dimension_names = names_of(member(metadata, "dimension_names"), array.shape.size());
  if (array.dimension_names.empty()) {
    array.dimension_names = names_of(member(member(metadata, "attributes"), "_ARRAY_DIMENSIONS"), array.shape.size());
  }
  // A reader must reject storage transformers that it does not know.
  const Json& transformers = member(metadata, "storage_transformers");
  if (transformers.is_array() && !transformers.empty() && array.unsupported_feature.empty())
    array.unsupported_feature = "storage transformers";
  if (array.unsupported_feature.empty()) set_v3_codecs(member(metadata, "codecs"), array);
  return array;
}

}  // namespace isoextract_zarr
