// The text of a NRRD header, split before the library sees it: where the samples are is read here, so that no file is
// opened on a header's word, and lines that the library is not made for are found. Private to the NRRD reader.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::volume_io {

// Files numbered by a pattern: NAME%03d.raw MIN MAX STEP.
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

// What the "data file" field says.
struct NrrdDataFiles {
  std::vector<std::string> names;          // one, or those of a LIST
  std::optional<NrrdFilePattern> pattern;  // instead of names
  bool several = false;                    // a LIST or pattern: the slow axes count the files
  std::optional<unsigned> file_dimension;  // of each of several files; default: one less than the volume's

  [[nodiscard]] std::uint64_t count() const { return pattern ? pattern->count() : names.size(); }
  [[nodiscard]] std::string name(std::uint64_t i) const { return pattern ? pattern->name(i) : names[i]; }
};

struct NrrdHeaderText {
  // For the library: all lines but those of "data file", and without texts that are too long for it and say nothing of
  // the samples (comments, key/value pairs, the content).
  std::string fields;
  std::optional<NrrdDataFiles> detached;  // empty: the samples follow the header
  std::uint64_t data_offset = 0;          // of an attached file: behind the empty line
};

// Fails with ErrorCode::input where the text does not end, is binary, has a line that the library has no room for, or
// names its data files in a way that is not understood.
[[nodiscard]] Result<NrrdHeaderText> read_nrrd_header(const files::InputFile& file);

}  // namespace isoextract::volume_io
