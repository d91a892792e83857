// NumPy's array files (.npy), versions 1 to 3: a magic, a length, a Python dictionary as text, the samples. Debian has
// no library for them. Objects are refused, never unpickled.
#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/printable.hpp"
#include "volumes/detail/dense_format.hpp"
#include "volumes/detail/file_start.hpp"
#include "volumes/detail/formats.hpp"

namespace isoextract::volumes {
namespace {

constexpr std::string_view kNpyMagic("\x93NUMPY", 6);

struct NpyHeader {
  std::optional<std::string> descr;
  std::optional<bool> fortran_order;
  std::optional<std::vector<std::uint64_t>> shape;
};

// Reads {'descr': '<f4', 'fortran_order': False, 'shape': (3, 4, 5), } and nothing else of Python.
class DictParser {
 public:
  explicit DictParser(std::string_view text) : rest_(text) {}

  // Empty for anything that is not such a dictionary.
  std::optional<NpyHeader> parse() {
    NpyHeader header;
    if (!take('{')) return std::nullopt;
    while (!take('}')) {
      const auto key = string();
      if (!key || !take(':') || !value(*key, header)) return std::nullopt;
      if (!take(',') && !peek('}')) return std::nullopt;
    }
    skip_space();
    if (!rest_.empty() || !header.descr || !header.fortran_order || !header.shape) return std::nullopt;
    return header;
  }

 private:
  bool value(const std::string& key, NpyHeader& header) {
    if (key == "descr" && !header.descr) {
      if (peek('[')) {
        header.descr = "a structure";
        return skip_list();
      }
      return (header.descr = string()).has_value();
    }
    if (key == "fortran_order" && !header.fortran_order) {
      if (take_word("True")) header.fortran_order = true;
      if (take_word("False")) header.fortran_order = false;
      return header.fortran_order.has_value();
    }
    if (key == "shape" && !header.shape) return (header.shape = tuple()).has_value();
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
      take('L');  // Python 2 wrote long integers so
      numbers.push_back(number);
      if (!take(',') && !peek(')')) return std::nullopt;
    }
    return numbers;
  }

  // A structured type is only named in the refusal: its end is enough.
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
};

struct NpyType {
  field::SampleType type;
  std::endian endian;
};

std::optional<NpyType> parse_descr(std::string_view descr) {
  constexpr std::array<std::pair<std::string_view, field::SampleType>, 9> kTypes{{{"u1", field::SampleType::u8},
                                                                                  {"i1", field::SampleType::i8},
                                                                                  {"u2", field::SampleType::u16},
                                                                                  {"i2", field::SampleType::i16},
                                                                                  {"u4", field::SampleType::u32},
                                                                                  {"i4", field::SampleType::i32},
                                                                                  {"f2", field::SampleType::f16},
                                                                                  {"f4", field::SampleType::f32},
                                                                                  {"f8", field::SampleType::f64}}};
  if (descr.size() != 3) return std::nullopt;
  const auto* const found =
      std::ranges::find(kTypes, descr.substr(1), &std::pair<std::string_view, field::SampleType>::first);
  if (found == kTypes.end()) return std::nullopt;
  switch (descr.front()) {
    case '<': return NpyType{found->second, std::endian::little};
    case '>': return NpyType{found->second, std::endian::big};
    case '=':
    case '|': return NpyType{found->second, std::endian::native};
    default: return std::nullopt;
  }
}

// The text of the dictionary and where the samples begin.
struct NpyPreamble {
  std::string text;
  std::uint64_t data_offset;
};

Result<NpyPreamble> read_preamble(const files::InputFile& file) {
  std::array<std::byte, 12> start{};
  const auto known = static_cast<std::size_t>(std::min<std::uint64_t>(start.size(), file.size()));
  if (auto read = file.read_at(0, std::span(start).first(known)); !read) return tl::unexpected(read.error());
  if (!starts_with(start, kNpyMagic)) return fail_magic(file, "a NumPy file", "'\\x93NUMPY'");
  const int version = std::to_integer<int>(start[6]);
  if (version < 1 || version > 3) {
    return fail(ErrorKind::input, fmt::format("{}: expected NPY version 1, 2 or 3, found {}", file.name(), version));
  }
  const std::size_t length_bytes = version == 1 ? 2 : 4;
  std::uint64_t length = 0;
  for (std::size_t i = 0; i < length_bytes; ++i) length |= std::to_integer<std::uint64_t>(start[8 + i]) << (8 * i);
  const std::uint64_t begin = 8 + length_bytes;
  constexpr std::uint64_t kMaxLength = 1 << 20;
  if (begin + length > file.size() || length > kMaxLength) {
    return fail(ErrorKind::input, fmt::format("{}: the header should be {} bytes long, the file has {}", file.name(),
                                              begin + length, file.size()));
  }
  NpyPreamble preamble{std::string(length, '\0'), begin + length};
  if (auto read = file.read_at(begin, std::as_writable_bytes(std::span(preamble.text))); !read) {
    return tl::unexpected(read.error());
  }
  return preamble;
}

Result<DenseFile> open_npy(const files::InputFile& file) {
  const auto preamble = read_preamble(file);
  if (!preamble) return tl::unexpected(preamble.error());
  const auto header = DictParser(preamble->text).parse();
  if (!header) {
    return fail(ErrorKind::input,
                fmt::format("{}: expected a header with 'descr', 'fortran_order' and 'shape', found {}", file.name(),
                            printable(preamble->text, 120)));
  }
  const auto type = parse_descr(*header->descr);
  if (!type) {
    return fail(ErrorKind::input,
                fmt::format("{}: expected numbers of type u1, i1, u2, i2, u4, i4, f2, f4 or f8, found {}", file.name(),
                            printable(*header->descr, 40)),
                "convert the array in NumPy, for example with a.astype('f4')");
  }

  DenseFile dense;
  std::vector<std::uint64_t> shape = *header->shape;
  const std::size_t axes = shape.size();
  while (shape.size() > 3 && shape.front() == 1) shape.erase(shape.begin());
  const std::size_t kept = shape.size();
  if (kept != 3 && kept != 4) {
    return fail(ErrorKind::input,
                fmt::format("{}: expected an array with 3 axes [z, y, x], or 4 [t, z, y, x], found shape ({})",
                            file.name(), fmt::join(*header->shape, ", ")));
  }
  if (axes > kept) dense.notes.push_back(fmt::format("{} leading axes of length 1 were dropped", axes - kept));
  if (kept == 4) {
    dense.volumes = shape.front();
    shape.erase(shape.begin());
  }
  const auto dims = checked_dims(file.name(), {shape[2], shape[1], shape[0]}, type->type);
  if (!dims) return tl::unexpected(dims.error());
  if (auto fine = check_volume_count(file.name(), *dims, type->type, dense.volumes); !fine) {
    return tl::unexpected(fine.error());
  }

  dense.format = "NPY";
  dense.type = type->type;
  dense.dims = *dims;
  dense.endian = type->endian;
  // The order of storage, not of the axes: [t, z, y, x] all the same, but its first axis is the fastest.
  dense.x_slowest = *header->fortran_order;
  dense.interleaved = *header->fortran_order;
  dense.pieces = {{file.path(), preamble->data_offset}};
  dense.size_is_exact = true;
  return dense;
}

class NpyFormat final : public DenseFormat {
 public:
  NpyFormat()
      : DenseFormat({.id = "npy",
                     .title = "NumPy array [z, y, x] or [t, z, y, x]",
                     .extensions = {".npy"},
                     .has_volumes = true}) {}

  [[nodiscard]] bool probe(const FileStart& start) const override {
    return !start.packed && starts_with(start.bytes, kNpyMagic);
  }

 protected:
  [[nodiscard]] Result<DenseFile> open_header(const files::InputFile& file,
                                              const ReadOptions& /*options*/) const override {
    return open_npy(file);
  }
};

}  // namespace

const VolumeFormat& npy_format() {
  static const NpyFormat format;
  return format;
}

}  // namespace isoextract::volumes
