// Files, numbers as text, and boxes of samples in files.
#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cstring>
#include <filesystem>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "vtk_volume.hpp"

namespace isoextract_vtk {

InputFile::InputFile(const std::string& path) : handle_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  struct stat facts {};
  if (handle_ < 0 || ::fstat(handle_, &facts) != 0 || !S_ISREG(facts.st_mode)) {
    if (handle_ >= 0) ::close(handle_);
    throw ReadError("cannot open the file " + std::filesystem::path(path).filename().string());
  }
  size_ = static_cast<std::uint64_t>(facts.st_size);
}

InputFile::~InputFile() { ::close(handle_); }

void InputFile::read_at(std::uint64_t offset, void* to, std::uint64_t bytes) const {
  if (offset > size_ || bytes > size_ - offset) {
    throw ReadError("expected " + std::to_string(bytes) + " bytes at offset " + std::to_string(offset) +
                    ", found the end of the file at " + std::to_string(size_));
  }
  auto* at = static_cast<char*>(to);
  while (bytes > 0) {
    const ssize_t got = ::pread(handle_, at, bytes, static_cast<off_t>(offset));
    if (got <= 0) throw ReadError("cannot read the file at offset " + std::to_string(offset));
    at += got;
    offset += static_cast<std::uint64_t>(got);
    bytes -= static_cast<std::uint64_t>(got);
  }
}

std::string InputFile::text_at(std::uint64_t offset, std::uint64_t most) const {
  std::string text(offset < size_ ? std::min(most, size_ - offset) : 0, '\0');
  read_at(std::min(offset, size_), text.data(), text.size());
  return text;
}

namespace {

template <class Word, class Swap>
void swap_words(char* at, std::uint64_t count, Swap&& swap) {
  for (std::uint64_t i = 0; i < count; ++i, at += sizeof(Word)) {
    Word word = 0;
    std::memcpy(&word, at, sizeof word);
    word = swap(word);
    std::memcpy(at, &word, sizeof word);
  }
}

void swap_bytes(char* at, std::uint64_t bytes, std::uint64_t count) {
  if (bytes == 2) swap_words<std::uint16_t>(at, count, [](std::uint16_t word) { return __builtin_bswap16(word); });
  if (bytes == 4) swap_words<std::uint32_t>(at, count, [](std::uint32_t word) { return __builtin_bswap32(word); });
  if (bytes == 8) swap_words<std::uint64_t>(at, count, [](std::uint64_t word) { return __builtin_bswap64(word); });
}

}  // namespace

void to_native(StoredType type, bool swap, void* samples, std::uint64_t count) {
  const std::uint64_t bytes = type.bytes();
  auto* at = static_cast<char*>(samples);
  if (swap) swap_bytes(at, bytes, count);
  if (type.wide == StoredType::Wide::none) return;
  for (std::uint64_t i = 0; i < count; ++i) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, at + i * bytes, bytes);
    const double value = type.wide == StoredType::Wide::i64 ? static_cast<double>(std::bit_cast<std::int64_t>(bits))
                                                            : static_cast<double>(bits);
    std::memcpy(at + i * bytes, &value, bytes);
  }
}

namespace {

// The samples that the selection and a stored box share, in the grid's coordinates.
struct Shared {
  Dims first{};
  Dims end{};
  bool empty = false;
};

Shared shared_samples(const StoredBox& stored, const isoextract_volume_selection& selection) {
  Shared shared;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    shared.first[axis] = std::max(stored.first[axis], selection.first[axis]);
    shared.end[axis] = std::min(stored.first[axis] + stored.dims[axis], selection.first[axis] + selection.count[axis]);
    shared.empty = shared.empty || shared.first[axis] >= shared.end[axis];
  }
  return shared;
}

}  // namespace

void fill_from_stored(const Grid& grid, const StoredBox& stored, const ReadNumbers& read,
                      const isoextract_volume_selection& selection, const isoextract_plugin_host& host) {
  const Shared shared = shared_samples(stored, selection);
  if (shared.empty) return;
  const std::uint64_t to_bytes = isoextract_plugin::sample_size(isoextract_plugin::selected_type(grid, selection));
  const auto box_at = [&](std::uint64_t y, std::uint64_t z) {
    const std::uint64_t sample =
        ((z - selection.first[2]) * selection.count[1] + (y - selection.first[1])) * selection.count[0] +
        (shared.first[0] - selection.first[0]);
    return static_cast<char*>(selection.box) + sample * to_bytes;
  };
  // Returns the index of the first number of stored row (y, z).
  const auto row_at = [&](std::uint64_t y, std::uint64_t z) {
    return ((z - stored.first[2]) * stored.dims[1] + (y - stored.first[1])) * stored.dims[0] * grid.components;
  };
  const std::uint64_t rows = shared.end[1] - shared.first[1];
  const std::uint64_t numbers = rows * stored.dims[0] * grid.components;
  const bool whole_rows = shared.first[0] == stored.first[0] && shared.end[0] == stored.first[0] + stored.dims[0];
  const bool as_stored = grid.components == 1 && selection.component == 0 && whole_rows &&
                         (selection.count[0] == stored.dims[0] || rows == 1);
  HostMemory memory(host);
  std::vector<char> slice;
  if (!as_stored) {
    memory.take(numbers * stored.type.bytes());
    slice.resize(numbers * stored.type.bytes());
  }
  for (std::uint64_t z = shared.first[2]; z < shared.end[2]; ++z) {
    isoextract_plugin::check_cancelled(host);
    char* const to = as_stored ? box_at(shared.first[1], z) : slice.data();
    read(row_at(shared.first[1], z), numbers, to);
    to_native(stored.type, stored.swap, to, numbers);
    if (as_stored) continue;
    const isoextract_plugin::SamplesInMemory rows_in_memory =
        isoextract_plugin::interleaved_samples(to, {stored.dims[0], rows, 1}, grid.components);
    for (std::uint64_t y = 0; y < rows; ++y) {
      isoextract_volume_selection row = selection;
      row.first[0] = shared.first[0] - stored.first[0];
      row.first[1] = y;
      row.first[2] = 0;
      row.count[0] = shared.end[0] - shared.first[0];
      row.count[1] = row.count[2] = 1;
      row.box = box_at(shared.first[1] + y, z);
      isoextract_plugin::fill_box(grid, rows_in_memory, row);
    }
  }
}

std::optional<std::uint64_t> product(const std::vector<std::uint64_t>& factors, std::uint64_t limit) {
  std::uint64_t result = 1;
  for (const std::uint64_t factor : factors) {
    if (factor != 0 && result > limit / factor) return std::nullopt;
    result *= factor;
  }
  return result;
}

void check_fits(const InputFile& file, std::uint64_t offset, const std::vector<std::uint64_t>& counts,
                std::uint64_t bytes) {
  std::string text;
  for (const std::uint64_t count : counts) text += (text.empty() ? "" : " x ") + std::to_string(count);
  const std::uint64_t there = file.size() > offset ? file.size() - offset : 0;
  const auto count = product(counts, there / bytes);
  if (!count || *count == 0) {
    throw ReadError("expected " + text + " numbers of " + std::to_string(bytes) + " bytes, found " +
                    std::to_string(there) + " bytes");
  }
}

std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words;
  const auto is_space = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  for (auto at = text.begin(); at != text.end();) {
    at = std::find_if_not(at, text.end(), is_space);
    const auto end = std::find_if(at, text.end(), is_space);
    if (at != end) words.emplace_back(at, end);
    at = end;
  }
  return words;
}

std::optional<double> parse_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (status == std::errc::result_out_of_range) {  // a number with an exponent such as E-400 is 0
    const std::size_t exponent = word.find_first_of("eE");
    if (exponent == std::string_view::npos || exponent + 1 >= word.size() || word[exponent + 1] != '-') {
      return std::nullopt;
    }
    return 0.0;
  }
  if (status != std::errc{}) return std::nullopt;
  const std::string_view rest = word.substr(static_cast<std::size_t>(end - word.data()));
  if (rest.empty()) return value;
  std::string normal(word.substr(0, word.size() - rest.size()));
  if (rest[0] == 'd' || rest[0] == 'D') {
    normal += 'e' + std::string(rest.substr(1));
  } else if (rest[0] == '-' || rest[0] == '+') {
    normal += 'e' + std::string(rest);
  } else {
    return std::nullopt;
  }
  if (rest.size() < 2 || normal.find_first_of("dD") != std::string::npos) return std::nullopt;
  return std::ranges::count(normal, 'e') == 1 ? parse_number(normal) : std::nullopt;
}

std::optional<std::int64_t> parse_integer(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  std::int64_t value = 0;
  const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (status != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return value;
}

std::string printed(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 6).ptr;
  return {text.data(), end};
}

std::string path_beside(const std::string& path, const std::string& name) {
  namespace fs = std::filesystem;
  const fs::path named(name);
  if (named.empty() || named.is_absolute() || std::ranges::find(named, fs::path("..")) != named.end()) {
    throw ReadError("expected the name of a file in the same folder or below it, found " + name.substr(0, 200));
  }
  return (fs::path(path).parent_path() / named).string();
}

}  // namespace isoextract_vtk
