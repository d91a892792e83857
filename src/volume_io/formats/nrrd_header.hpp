// Splits the text of an NRRD header before teem parses it. The location of the samples is parsed here, so that teem
// opens no files, and lines that teem cannot handle are rejected. Private to the NRRD reader.
#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "base/ascii.hpp"
#include "base/error.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::volume_io {

// Numbered data files: NAME%03d.raw MIN MAX STEP.
struct NrrdFilePattern {
  std::string prefix;
  std::string suffix;
  int width = 0;
  bool zero_padded = false;
  std::int64_t first = 0;
  std::int64_t last = 0;
  std::int64_t step = 1;

  [[nodiscard]] std::uint64_t count() const;
  [[nodiscard]] std::string name(std::uint64_t i) const;
};

// The value of the "data file" field.
struct NrrdDataFiles {
  std::vector<std::string> names;          // one, or those of a LIST
  std::optional<NrrdFilePattern> pattern;  // replaces names
  bool several = false;                    // a LIST or pattern: the slow axes enumerate the files
  std::optional<unsigned> file_dimension;  // dimension of each of several files; default: one less than the volume's

  [[nodiscard]] std::uint64_t count() const { return pattern ? pattern->count() : names.size(); }
  [[nodiscard]] std::string name(std::uint64_t i) const { return pattern ? pattern->name(i) : names[i]; }
};

struct NrrdHeaderText {
  // Input for teem: all lines except "data file", and without texts that do not describe the samples (comments,
  // key/value pairs, content).
  std::string fields;
  std::vector<std::string> segments;      // the key/value pairs "SegmentN_KEY:=VALUE" of 3D Slicer
  std::optional<NrrdDataFiles> detached;  // empty: the samples follow the header
  std::uint64_t data_offset = 0;          // of an attached file: after the empty line
};

// Removes a number and the blanks before it from `text`; returns nothing if `text` does not start with a number.
template <class T>
[[nodiscard]] std::optional<T> take_number(std::string_view& text) {
  text = trimmed(text);
  T number{};
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (status != std::errc{}) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

// Reads the header. Fails with ErrorCode::input if the text does not end, is binary, has a line that would overflow
// teem's buffers, or names its data files twice or in an unsupported way.
[[nodiscard]] Result<NrrdHeaderText> read_nrrd_header(const files::InputFile& file);

}  // namespace isoextract::volume_io
