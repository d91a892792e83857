// Houdini's binary JSON (SideFX Houdini Development Kit, UT_JSONDefines.h): a stream of tokens, each a byte and its
// data, in the byte order given by the signature.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>

#include "particle_io/detail/content_reader.hpp"
#include "particle_io/detail/number_type.hpp"

namespace isoextract::particle_io {

inline constexpr std::string_view kHoudiniMagicLittle("\x7FNSJb", 5);
inline constexpr std::string_view kHoudiniMagicBig(
    "\x7F"
    "bJSN",
    5);

struct JsonToken {
  enum class Kind { null, number, text, begin, end, numbers, bits, texts, names, finished };
  Kind kind = Kind::null;             // begin and end: of an array or a map
  double number = 0;                  // of number tokens; booleans are 0 or 1
  std::string text;                   // of text tokens; truncated to kMaxText bytes, texts in names_ to 256
  std::uint64_t count = 0;            // of uniform arrays: number of elements that follow
  NumberType type = NumberType::f64;  // of uniform arrays: type of the elements
};

// Throws InvalidParticleFile and Refused.
class HoudiniJson {
 public:
  static constexpr std::size_t kMaxText = 4096;

  // Consumes the signature.
  explicit HoudiniJson(ContentReader& content);

  // Returns the next token. Read or skip the elements of a uniform array before the next call.
  [[nodiscard]] JsonToken next();
  // Skips the rest of the value that starts with `first`.
  void skip_value(const JsonToken& first);

  // Calls take(value) for all numbers of the value that starts with `first`, in order, at any depth of nested arrays.
  template <class F>
  void each_number(const JsonToken& first, F&& take) {
    std::uint64_t depth = 0;
    JsonToken token = first;
    while (true) {
      switch (token.kind) {
        case JsonToken::Kind::begin: ++depth; break;
        case JsonToken::Kind::end:
          if (depth == 0) expected("numbers");
          --depth;
          break;
        case JsonToken::Kind::number: take(token.number); break;
        case JsonToken::Kind::numbers: uniform_numbers(token, take); break;
        case JsonToken::Kind::bits: uniform_bits(token.count, take); break;
        default: expected("numbers");
      }
      if (depth == 0) return;
      token = next();
    }
  }

  // Calls take(text) for all texts of the array that starts with `first`, in order.
  template <class F>
  void each_text(const JsonToken& first, F&& take) {
    if (first.kind == JsonToken::Kind::texts) {
      for (std::uint64_t i = 0; i < first.count; ++i) take(text());
      return;
    }
    if (first.kind != JsonToken::Kind::begin) expected("an array of texts");
    for (JsonToken token = next(); token.kind != JsonToken::Kind::end; token = next()) {
      if (token.kind == JsonToken::Kind::texts) {
        each_text(token, take);
      } else if (token.kind == JsonToken::Kind::text) {
        take(token.text);
      } else {
        expected("a text");
      }
    }
  }

  [[noreturn]] void expected(std::string_view what) const;
  [[nodiscard]] ContentReader& content() { return content_; }

 private:
  template <class F>
  void uniform_numbers(const JsonToken& token, F&& take) {
    const std::size_t size = number_size(token.type);
    for (std::uint64_t left = token.count; left > 0;) {
      const auto bytes = content_.peek(size);
      const auto at_hand = static_cast<std::size_t>(std::min<std::uint64_t>(left, bytes.size() / size));
      if (at_hand == 0) expected("more numbers");
      for_each_number(token.type, endian_, bytes.data(), size, at_hand,
                      [&](std::size_t, double value) { take(value); });
      content_.advance(at_hand * size);
      left -= at_hand;
    }
  }

  // Bits are stored in 32-bit words, the lowest bit first.
  template <class F>
  void uniform_bits(std::uint64_t count, F&& take) {
    for (std::uint64_t i = 0; i < count; i += 32) {
      const std::uint64_t word = whole(4);
      for (std::uint64_t bit = 0; bit < 32 && i + bit < count; ++bit) take((word >> bit & 1) != 0 ? 1.0 : 0.0);
    }
  }

  [[nodiscard]] std::uint64_t whole(std::size_t bytes);
  [[nodiscard]] std::uint64_t length();
  [[nodiscard]] double number(NumberType type);
  [[nodiscard]] std::string text();
  void skip_elements(const JsonToken& token);
  [[nodiscard]] JsonToken uniform_array();

  ContentReader& content_;
  std::endian endian_ = std::endian::little;
  std::unordered_map<std::uint64_t, std::string> names_;  // texts that later tokens refer to
};

}  // namespace isoextract::particle_io
