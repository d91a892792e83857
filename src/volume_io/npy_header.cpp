#include "volume_io/npy_header.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "files/file_start.hpp"

namespace isoextract::volume_io {
namespace {

// Parses {'descr': '<f4', 'fortran_order': False, 'shape': (3, 4, 5), } and no other Python.
class NpyDictParser {
 public:
  explicit NpyDictParser(std::string_view text) : rest_(text) {}

  // Returns nothing for any other text.
  std::optional<NpyHeader> parse() {
    if (!take('{')) return std::nullopt;
    while (!take('}')) {
      const auto key = string();
      if (!key || !take(':') || !value(*key)) return std::nullopt;
      if (!take(',') && !peek('}')) return std::nullopt;
    }
    skip_space();
    if (!rest_.empty() || !descr_ || !fortran_order_ || !shape_) return std::nullopt;
    return NpyHeader{std::move(*descr_), std::move(fields_), *fortran_order_, std::move(*shape_), 0};
  }

 private:
  bool value(const std::string& key) {
    if (key == "descr" && !descr_) {
      if (peek('[')) {
        descr_ = "a structure";
        return list();
      }
      return (descr_ = string()).has_value();
    }
    if (key == "fortran_order" && !fortran_order_) {
      if (take_word("True")) fortran_order_ = true;
      if (take_word("False")) fortran_order_ = false;
      return fortran_order_.has_value();
    }
    if (key == "shape" && !shape_) return (shape_ = tuple()).has_value();
    return false;
  }

  std::optional<std::string> string() {
    skip_space();
    if (rest_.empty() || (rest_.front() != '\'' && rest_.front() != '"')) return std::nullopt;
    const std::size_t end = rest_.find(rest_.front(), 1);
    if (end == std::string_view::npos) return std::nullopt;
    std::string text(rest_.substr(1, end - 1));
    rest_.remove_prefix(end + 1);
    return text;
  }

  std::optional<std::vector<std::uint64_t>> tuple() {
    std::vector<std::uint64_t> numbers;
    if (!take('(')) return std::nullopt;
    while (!take(')')) {
      skip_space();
      std::uint64_t number = 0;
      const auto [end, status] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), number);
      if (status != std::errc{} || numbers.size() == 64) return std::nullopt;
      rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
      take('L');  // suffix of long integers in Python 2
      numbers.push_back(number);
      if (!take(',') && !peek(')')) return std::nullopt;
    }
    return numbers;
  }

  // Accepts [('x', '<f4'), ('v', '<f4', (3,))]. Skips any other list up to its closing bracket.
  bool list() {
    const std::string_view whole = rest_;
    if (flat_list()) return true;
    fields_.clear();
    rest_ = whole;
    return skip_list();
  }

  bool flat_list() {
    if (!take('[')) return false;
    while (!take(']')) {
      NpyField field;
      if (!take('(')) return false;
      auto name = string();
      if (!name || !take(',')) return false;
      auto descr = string();
      if (!descr) return false;
      field.name = std::move(*name);
      field.descr = std::move(*descr);
      if (take(',') && !peek(')')) {
        auto shape = tuple();
        if (!shape) return false;
        field.shape = std::move(*shape);
      }
      if (!take(')') || (!take(',') && !peek(']'))) return false;
      fields_.push_back(std::move(field));
    }
    return true;
  }

  bool skip_list() {
    int depth = 0;
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      if (rest_[i] == '[') ++depth;
      if (rest_[i] == ']' && --depth == 0) {
        rest_.remove_prefix(i + 1);
        return true;
      }
    }
    return false;
  }

  void skip_space() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\r\n"), rest_.size())); }

  bool peek(char c) {
    skip_space();
    return rest_.starts_with(c);
  }

  bool take(char c) {
    if (!peek(c)) return false;
    rest_.remove_prefix(1);
    return true;
  }

  bool take_word(std::string_view word) {
    skip_space();
    if (!rest_.starts_with(word)) return false;
    rest_.remove_prefix(word.size());
    return true;
  }

  std::string_view rest_;
  std::optional<std::string> descr_;
  std::vector<NpyField> fields_;
  std::optional<bool> fortran_order_;
  std::optional<std::vector<std::uint64_t>> shape_;
};

// Returns the size in bytes of the length field that follows the version.
std::size_t length_bytes(int version) { return version == 1 ? 2 : 4; }

std::uint64_t dict_length(std::span<const std::byte> start, int version) {
  std::uint64_t length = 0;
  for (std::size_t i = 0; i < length_bytes(version); ++i) {
    length |= std::to_integer<std::uint64_t>(start[8 + i]) << (8 * i);
  }
  return length;
}

}  // namespace

Result<NpyHeader> read_npy_header(const files::InputFile& file) {
  std::array<std::byte, 12> start{};
  const auto known = static_cast<std::size_t>(std::min<std::uint64_t>(start.size(), file.size()));
  TRY(file.read_at(0, std::span(start).first(known)));
  if (files::is_gzip(std::span(start).first(known))) {
    return fail(ErrorCode::input, file.name() + ": expected an uncompressed NumPy file, found a gzip file",
                "decompress the file first");
  }
  if (!files::starts_with(start, kNpyMagic)) return files::bad_signature_error(file, "a NumPy file", "'\\x93NUMPY'");
  const std::uint64_t header = std::min(8 + length_bytes(2) + dict_length(start, std::to_integer<int>(start[6])),
                                        std::min(kMaxNpyHeader, file.size()));
  std::vector<std::byte> bytes(static_cast<std::size_t>(header));
  TRY(file.read_at(0, bytes));
  return parse_npy_header(file.name(), bytes, file.size());
}

Result<NpyHeader> parse_npy_header(const std::string& name, std::span<const std::byte> start, std::uint64_t size) {
  if (!files::starts_with(start, kNpyMagic)) {
    return fail(ErrorCode::input, fmt::format("{}: not a NumPy array: expected '\\x93NUMPY' at the start, found '{}'",
                                              name, printable(start, 16)));
  }
  const int version = start.size() > 6 ? std::to_integer<int>(start[6]) : 0;
  if (version < 1 || version > 3) {
    return fail(ErrorCode::input, fmt::format("{}: expected NPY version 1, 2 or 3, found {}", name, version));
  }
  const std::uint64_t begin = 8 + length_bytes(version);
  const std::uint64_t length = start.size() < begin ? 0 : dict_length(start, version);
  if (length == 0 || begin + length > size || begin + length > start.size()) {
    return fail(
        ErrorCode::input,
        fmt::format("{}: the header is damaged or longer than {} bytes: it ends at byte {}, the file has {} bytes",
                    name, kMaxNpyHeader, begin + length, size));
  }
  const std::string_view text(reinterpret_cast<const char*>(start.data()) + begin, static_cast<std::size_t>(length));
  auto header = NpyDictParser(text).parse();
  if (!header) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected a header with 'descr', 'fortran_order' and 'shape', found {}", name,
                            printable(std::string(text), 120)));
  }
  header->data_offset = begin + length;
  return std::move(*header);
}

std::optional<NpyHeader> npy_header_in(std::span<const std::byte> start) {
  if (start.size() < 12 || !files::starts_with(start, kNpyMagic)) return std::nullopt;
  const int version = std::to_integer<int>(start[6]);
  if (version < 1 || version > 3) return std::nullopt;
  const std::size_t begin = 8 + length_bytes(version);
  const std::uint64_t length = dict_length(start, version);
  if (length > start.size() - begin) return std::nullopt;
  return NpyDictParser({reinterpret_cast<const char*>(start.data()) + begin, static_cast<std::size_t>(length)}).parse();
}

}  // namespace isoextract::volume_io
