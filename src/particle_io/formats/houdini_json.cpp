#include "particle_io/formats/houdini_json.hpp"

#include <algorithm>
#include <cstring>
#include <optional>

#include <fmt/format.h>

#include "files/file_start.hpp"
#include "particle_io/detail/particle_source.hpp"

namespace isoextract::particle_io {
namespace {

constexpr std::size_t kMostNames = 4096;

enum JsonCode : unsigned {
  kNull = 0x00,
  kBool = 0x10,
  kNameReference = 0x26,
  kText = 0x27,
  kNameDefinition = 0x2b,
  kNameEnd = 0x2d,
  kFalse = 0x30,
  kTrue = 0x31,
  kUniformArray = 0x40,
  kArrayBegin = 0x5b,
  kArrayEnd = 0x5d,
  kMapBegin = 0x7b,
  kMapEnd = 0x7d,
};

std::optional<NumberType> number_of_code(unsigned code) {
  switch (code) {
    case 0x11: return NumberType::i8;
    case 0x12: return NumberType::i16;
    case 0x13: return NumberType::i32;
    case 0x14: return NumberType::i64;
    case 0x18: return NumberType::f16;
    case 0x19: return NumberType::f32;
    case 0x1a: return NumberType::f64;
    case 0x21: return NumberType::u8;
    case 0x22: return NumberType::u16;
    default: return std::nullopt;
  }
}

}  // namespace

HoudiniJson::HoudiniJson(ContentReader& content) : content_(content) {
  const auto magic = content.take(kHoudiniMagicLittle.size(), "the magic");
  if (files::starts_with(magic, kHoudiniMagicBig)) {
    endian_ = std::endian::big;
  } else if (!files::starts_with(magic, kHoudiniMagicLittle)) {
    throw InvalidParticleFile("expected Houdini's binary JSON, found other bytes");
  }
}

void HoudiniJson::expected(std::string_view what) const {
  throw InvalidParticleFile(
      fmt::format("expected {} before byte {}, found other data or the end of the file", what, content_.position()));
}

std::uint64_t HoudiniJson::whole(std::size_t bytes) {
  const auto taken = content_.take(bytes, "a whole number");
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) {
    const std::size_t from = endian_ == std::endian::little ? bytes - 1 - i : i;
    value = value << 8 | std::to_integer<std::uint64_t>(taken[from]);
  }
  return value;
}

std::uint64_t HoudiniJson::length() {
  const std::uint64_t first = whole(1);
  switch (first) {
    case 0xf2: return whole(2);
    case 0xf4: return whole(4);
    case 0xf8: return whole(8);
    default: break;
  }
  if (first > 0xf0) expected("a length");
  return first;
}

double HoudiniJson::number(NumberType type) {
  const auto bytes = content_.take(number_size(type), "a number");
  double number = 0;
  for_each_number(type, endian_, bytes.data(), 0, 1, [&](std::size_t, double value) { number = value; });
  return number;
}

std::string HoudiniJson::text() {
  const std::uint64_t bytes = length();
  const auto kept = static_cast<std::size_t>(std::min<std::uint64_t>(bytes, kMaxText));
  const auto taken = content_.take(kept, "a text");
  std::string text(reinterpret_cast<const char*>(taken.data()), kept);
  content_.skip(bytes - kept, "a text");
  return text;
}

JsonToken HoudiniJson::uniform_array() {
  JsonToken token;
  const auto code = static_cast<unsigned>(whole(1));
  token.count = length();
  std::uint64_t least = token.count;  // fewest bytes that the elements need
  if (const auto type = number_of_code(code)) {
    token.kind = JsonToken::Kind::numbers;
    token.type = *type;
    if (token.count > content_.max_remaining_bytes() / number_size(*type))
      expected("as many numbers as the array announces");
    return token;
  }
  switch (code) {
    case kBool:
      token.kind = JsonToken::Kind::bits;
      least = token.count / 8;
      break;
    case kText: token.kind = JsonToken::Kind::texts; break;
    case kNameReference: token.kind = JsonToken::Kind::names; break;
    default: expected("a type of the elements of an array");
  }
  if (least > content_.max_remaining_bytes()) expected("as many elements as the array announces");
  return token;
}

JsonToken HoudiniJson::next() {
  while (true) {
    if (content_.peek(1).empty()) return {JsonToken::Kind::finished, 0, {}, 0, {}};
    const auto code = static_cast<unsigned>(whole(1));
    if (const auto type = number_of_code(code)) return {JsonToken::Kind::number, number(*type), {}, 0, {}};
    switch (code) {
      case kNull: return {};
      case kBool: return {JsonToken::Kind::number, whole(1) != 0 ? 1.0 : 0.0, {}, 0, {}};
      case kFalse: return {JsonToken::Kind::number, 0, {}, 0, {}};
      case kTrue: return {JsonToken::Kind::number, 1, {}, 0, {}};
      case kText: return {JsonToken::Kind::text, 0, text(), 0, {}};
      case kArrayBegin:
      case kMapBegin: return {JsonToken::Kind::begin, 0, {}, 0, {}};
      case kArrayEnd:
      case kMapEnd: return {JsonToken::Kind::end, 0, {}, 0, {}};
      case kUniformArray: return uniform_array();
      case kNameReference: {
        const auto name = names_.find(length());
        if (name == names_.end()) expected("the definition of a name");
        return {JsonToken::Kind::text, 0, name->second, 0, {}};
      }
      case kNameDefinition: {
        const std::uint64_t id = length();
        if (names_.size() == kMostNames && !names_.contains(id)) expected("fewer names");
        names_[id] = text().substr(0, 256);
        break;
      }
      case kNameEnd: names_.erase(length()); break;
      default: expected("a token of Houdini's binary JSON");
    }
  }
}

void HoudiniJson::skip_elements(const JsonToken& token) {
  switch (token.kind) {
    case JsonToken::Kind::numbers: content_.skip(token.count * number_size(token.type), "numbers"); break;
    case JsonToken::Kind::bits: content_.skip((token.count + 31) / 32 * 4, "truth values"); break;
    case JsonToken::Kind::texts:
      for (std::uint64_t i = 0; i < token.count; ++i) content_.skip(length(), "a text");
      break;
    case JsonToken::Kind::names:
      for (std::uint64_t i = 0; i < token.count; ++i) static_cast<void>(length());
      break;
    default: break;
  }
}

void HoudiniJson::skip_value(const JsonToken& first) {
  std::uint64_t depth = 0;
  JsonToken token = first;
  while (true) {
    if (token.kind == JsonToken::Kind::finished) expected("the end of an array");
    if (token.kind == JsonToken::Kind::begin) ++depth;
    if (token.kind == JsonToken::Kind::end) {
      if (depth == 0) expected("a value");
      --depth;
    }
    skip_elements(token);
    if (depth == 0) return;
    token = next();
  }
}

}  // namespace isoextract::particle_io
