// Iso values a frame, from a CSV file:
//
//   # threshold that keeps the water's volume
//   frame,iso
//   1,0.15
//   2,0.152
//
// The first line that is neither blank nor a comment (#) names the columns; `frame` and `iso` (in any case) are there
// once each, in any order, and others are not looked at. Fields are separated by tabs, semicolons or commas: by the
// first of these that the header has. They may be quoted ("0.15", with "" for a quote), but not go on over the end of a
// line. All lines have as many fields as the header. A frame with several iso values has a row for each.
// An iso value may be auto or a percentile such as p99 as well (convert/iso_choice.hpp). Decimals have a point or,
// where fields are not separated by commas, a comma in all rows, as spreadsheets write them in some languages. A byte
// order mark, CR before line ends, blanks around fields and a line "sep=;" before the header are ignored.
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
  // Fails with ErrorCode::input for a file that cannot be read or is larger than 256 MiB, and as parse() does.
  [[nodiscard]] static Result<IsoTable> read(const std::filesystem::path& path, const Context& context);

  // `name` is what messages call the text. Fails with ErrorCode::input for columns or fields that are missing, for what
  // is no iso value or no frame, and for a row that is there twice; the message begins with "name:line".
  [[nodiscard]] static Result<IsoTable> parse(std::string_view text, const std::string& name);

  // In the order of the rows; empty where the frame has none.
  [[nodiscard]] std::span<const convert::IsoChoice> isos_of(std::int64_t frame) const;

  // Fails with ErrorCode::input where a frame has no row. Rows of other frames are no error: there may be more of them
  // than are converted this time.
  [[nodiscard]] Result<void> check_covers(std::span<const std::int64_t> frames) const;

 private:
  struct Row {
    std::int64_t frame = 0;
    std::size_t line = 0;
    convert::IsoChoice iso;
  };
  [[nodiscard]] Result<void> sort_rows();

  std::string name_;
  std::vector<Row> rows_;                 // by frame, then as they were in the text
  std::vector<convert::IsoChoice> isos_;  // of the rows
};

}  // namespace isoextract::batch
