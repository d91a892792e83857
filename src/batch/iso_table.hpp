// A table of iso values for each frame, from a CSV file:
//
//   # threshold that keeps the water's volume
//   frame,iso
//   1,0.15
//   2,0.152
//
// The first line that is neither blank nor a comment (#) names the columns. `frame` and `iso` (in any letter case)
// occur once each, in any order; other columns are ignored. The separator is a tab if the header contains one, else a
// semicolon if the header contains one, else a comma. Fields may be quoted ("0.15", with "" for a quote), but end on
// their line. All lines have as many fields as the header. A frame with several iso values has a row for each. An iso
// value may also be auto, zero or a percentile such as p99 (iso_choice_of()). The decimal mark is a point, or a comma
// in all rows if commas do not separate fields, as spreadsheets write it in some languages.
//
// A byte order mark, CR before line ends, blanks around fields, and a line "sep=;" before the header are ignored.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/iso_choice.hpp"

namespace isoextract::batch {

class IsoTable {
 public:
  // Reads a file. Fails with ErrorCode::input if it cannot be read or is larger than 256 MiB, and as parse() does.
  [[nodiscard]] static Result<IsoTable> read(const std::filesystem::path& path, const Context& context);

  // Parses a text; messages call it `name`. Fails with ErrorCode::input for missing columns, another number of fields
  // than in the header, wrong quotes, an invalid iso value or frame number, two decimal marks, and a repeated row. The
  // message begins with "name:line", or with "name:" if there is no header.
  [[nodiscard]] static Result<IsoTable> parse(std::string_view text, const std::string& name);

  // Returns the iso values of a frame, in the order of the rows; empty if the frame has none.
  [[nodiscard]] std::span<const convert::IsoChoice> isos_of(std::int64_t frame) const;

  // Fails with ErrorCode::input if one of `frames` has no row. Rows of other frames are allowed: a run may convert only
  // a part of the table's frames.
  [[nodiscard]] Result<void> check_covers(std::span<const std::int64_t> frames) const;

 private:
  struct Row {
    std::int64_t frame = 0;
    std::size_t line = 0;
    convert::IsoChoice iso;
  };
  [[nodiscard]] Result<void> sort_rows();

  std::string name_;
  std::vector<Row> rows_;                 // ordered by frame, then by line
  std::vector<convert::IsoChoice> isos_;  // of each row
};

}  // namespace isoextract::batch
