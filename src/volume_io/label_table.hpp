// Names and colors of the labels in a label map.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"

namespace isoextract::volume_io {

struct LabelEntry {
  std::int64_t label = 0;
  std::string name;
  glm::dvec3 color{0.0};  // sRGB, each channel from 0 to 1

  friend bool operator==(const LabelEntry&, const LabelEntry&) = default;
};

class LabelTable {
 public:
  static constexpr std::uint64_t kMaxBytes = std::uint64_t{16} << 20;  // largest file size

  // Parses one label per line, in either format; blank lines and lines that start with # are skipped.
  //
  //   number red green blue alpha visible mesh "name"    ITK-SNAP label descriptions
  //   number name red green blue alpha                   FreeSurfer look-up tables, also of 3D Slicer
  //
  // Colors are integers from 0 to 255. Ignores alpha, whose meaning differs between programs, and visibility. Fails
  // with ErrorCode::input for any other line (with its number), for a repeated label and for a table without labels.
  // `source` starts the message.
  [[nodiscard]] static Result<LabelTable> parse(std::string_view text, const std::string& source);

  // Reads a file; also fails if it cannot be read or is larger than kMaxBytes.
  [[nodiscard]] static Result<LabelTable> read(const std::string& path, const Context& context);

  [[nodiscard]] const std::vector<LabelEntry>& entries() const { return entries_; }  // in ascending order of label
  // Returns null if the label is not in the table.
  [[nodiscard]] const LabelEntry* find(std::int64_t label) const;
  // Returns whether another label has the same name.
  [[nodiscard]] bool shares_name(const LabelEntry& entry) const;
  [[nodiscard]] const std::string& hash() const { return hash_; }  // of the table's text

 private:
  std::vector<LabelEntry> entries_;
  std::string hash_;
};

// Returns the sRGB color, each channel from 0 to 1, of a label without a table entry; consecutive labels get very
// different hues.
[[nodiscard]] glm::dvec3 default_label_color(std::int64_t label);

}  // namespace isoextract::volume_io
