// Mutates Houdini's binary JSON token by token: names and their values come twice, go, change places; counts become
// others. The first byte of an input is the options of the target (fuzz_particles.cpp).
#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fuzz/mutation.hpp"

namespace isoextract::fuzz {
namespace {

constexpr std::size_t kStart = 6;  // the options and the magic

struct Token {
  std::size_t begin = 0;
  std::size_t end = 0;
  unsigned code = 0;
};

class Tokens {
 public:
  explicit Tokens(const std::string& text)
      : text_(text),
        big_(text.compare(1, 5,
                          "\x7F"
                          "bJSN") == 0) {
    while (at_ < text_.size()) {
      const std::size_t begin = at_;
      const unsigned code = static_cast<unsigned char>(text_[at_++]);
      if (!pass(code) || at_ > text_.size()) {
        list_.push_back({begin, text_.size(), 0xff});
        return;
      }
      list_.push_back({begin, at_, code});
    }
  }

  [[nodiscard]] const std::vector<Token>& list() const { return list_; }
  [[nodiscard]] bool big() const { return big_; }

  // One past the last token of the value that begins at token t; a definition belongs to what follows it.
  [[nodiscard]] std::size_t value_end(std::size_t t) const {
    while (t < list_.size() && list_[t].code == 0x2b) ++t;
    int depth = 0;
    for (; t < list_.size(); ++t) {
      const unsigned code = list_[t].code;
      if (code == '[' || code == '{') ++depth;
      if (code == ']' || code == '}') --depth;
      if (depth <= 0) return t + 1;
    }
    return list_.size();
  }

 private:
  static std::size_t number_bytes(unsigned code) {
    switch (code) {
      case 0x10:
      case 0x11:
      case 0x21: return 1;
      case 0x12:
      case 0x18:
      case 0x22: return 2;
      case 0x13:
      case 0x19: return 4;
      case 0x14:
      case 0x1a: return 8;
      default: return 0;
    }
  }

  std::optional<std::uint64_t> length() {
    if (at_ >= text_.size()) return std::nullopt;
    const auto first = static_cast<unsigned char>(text_[at_++]);
    const std::size_t bytes = first == 0xf2 ? 2 : first == 0xf4 ? 4 : first == 0xf8 ? 8 : 0;
    if (bytes == 0) return first;
    if (bytes > text_.size() - at_) return std::nullopt;
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
      value = value << 8 | static_cast<unsigned char>(text_[at_ + (big_ ? i : bytes - 1 - i)]);
    }
    at_ += bytes;
    return value;
  }

  bool skip(std::optional<std::uint64_t> bytes) {
    if (!bytes || *bytes > text_.size() - std::min(at_, text_.size())) return false;
    at_ += static_cast<std::size_t>(*bytes);
    return true;
  }

  bool pass(unsigned code) {
    if (const std::size_t bytes = number_bytes(code)) return skip(bytes);
    switch (code) {
      case 0x26:
      case 0x2d: return length().has_value();
      case 0x27: return skip(length());
      case 0x2b: return length() && skip(length());
      case 0x40: return pass_array();
      default: return true;
    }
  }

  bool pass_array() {
    if (at_ >= text_.size()) return false;
    const unsigned code = static_cast<unsigned char>(text_[at_++]);
    const auto count = length();
    if (!count || *count > text_.size() * 8) return false;
    if (code == 0x10) return skip((*count + 31) / 32 * 4);
    if (const std::size_t bytes = number_bytes(code)) return skip(*count * bytes);
    for (std::uint64_t i = 0; i < *count; ++i) {
      const auto bytes = length();
      if (!bytes || (code == 0x27 && !skip(bytes))) return false;
    }
    return true;
  }

  const std::string& text_;
  bool big_;
  std::size_t at_ = kStart;
  std::vector<Token> list_;
};

constexpr std::array<std::string_view, 22> kNames{
    "pointcount",       "primitivecount", "attributes", "pointattributes",
    "vertexattributes", "name",           "type",       "size",
    "storage",          "values",         "tuples",     "arrays",
    "rawpagedata",      "packing",        "pagesize",   "constantpageflags",
    "numeric",          "string",         "P",          "v",
    "fpreal32",         "defaults"};

class Mutation {
 public:
  Mutation(std::string text, unsigned seed, std::size_t most)
      : text_(std::move(text)), tokens_(text_), choices_(seed), most_(most) {}

  std::string run() {
    const std::vector<Token>& list = tokens_.list();
    if (list.empty()) return choices_.mutated(text_, most_);
    const std::size_t t = choices_.below(list.size());
    const std::size_t last = tokens_.value_end(t);
    switch (choices_.below(8)) {
      case 0: return repeated(t, tokens_.value_end(last));  // a name and its value
      case 1: return repeated(t, last);
      case 2: return text_.substr(0, list[t].begin) + text_.substr(end_of(last));
      case 3: return swapped(t, last);
      case 4: return with_number(t);
      case 5: return with_name(t);
      case 6: return with_payload(t);
      default: return choices_.mutated(text_, most_);
    }
  }

 private:
  // Where the token before `t` ends.
  [[nodiscard]] std::size_t end_of(std::size_t t) const { return t == 0 ? kStart : tokens_.list()[t - 1].end; }

  std::string repeated(std::size_t first, std::size_t last) {
    const std::size_t begin = tokens_.list()[first].begin;
    const std::string part = text_.substr(begin, end_of(last) - begin);
    // Mostly right behind, else anywhere.
    const std::size_t to = choices_.below(2) == 0 ? last : choices_.below(tokens_.list().size() + 1);
    return std::string(text_).insert(end_of(to), part);
  }

  std::string swapped(std::size_t first, std::size_t last) {
    if (last >= tokens_.list().size()) return choices_.mutated(text_, most_);
    const std::size_t a = tokens_.list()[first].begin;
    const std::size_t b = end_of(last);
    const std::size_t c = end_of(tokens_.value_end(last));
    return text_.substr(0, a) + text_.substr(b, c - b) + text_.substr(a, b - a) + text_.substr(c);
  }

  // The next number from there on becomes another one.
  std::string with_number(std::size_t t) {
    for (; t < tokens_.list().size(); ++t) {
      const Token& token = tokens_.list()[t];
      const bool is_number = (token.code >= 0x10 && token.code <= 0x14) || token.code == 0x21 || token.code == 0x22;
      if (!is_number) continue;
      const std::uint64_t value = choices_.number();
      const std::size_t bytes = token.end - token.begin - 1;
      for (std::size_t i = 0; i < bytes; ++i) {
        text_[token.begin + 1 + (tokens_.big() ? bytes - 1 - i : i)] = static_cast<char>(value >> (8 * i));
      }
      return text_;
    }
    return choices_.mutated(text_, most_);
  }

  std::string with_name(std::size_t t) {
    const Token& token = tokens_.list()[t];
    const std::string_view name = kNames[choices_.below(kNames.size())];
    const std::string made = "\x27" + std::string(1, static_cast<char>(name.size())) + std::string(name);
    return std::string(text_).replace(token.begin, token.end - token.begin, made);
  }

  std::string with_payload(std::size_t t) {
    const Token& token = tokens_.list()[t];
    const std::size_t bytes = token.end - token.begin;
    const std::string made = choices_.mutated(text_.substr(token.begin, bytes), bytes + 16);
    return std::string(text_).replace(token.begin, bytes, made);
  }

  std::string text_;
  Tokens tokens_;
  Choices choices_;
  std::size_t most_;
};

}  // namespace
}  // namespace isoextract::fuzz

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
  using namespace isoextract::fuzz;
  if (size < kStart) return LLVMFuzzerMutate(data, size, most);
  return give_back(Mutation({reinterpret_cast<const char*>(data), size}, seed, most).run(), data, size, most);
}
