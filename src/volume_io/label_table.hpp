// Names and colors of the labels in a label map.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::volume_io {

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

  // Returns all labels, with their colors, in ascending order of label.
  [[nodiscard]] const std::vector<field::LabelName>& entries() const { return entries_; }
  [[nodiscard]] const std::string& hash() const { return hash_; }  // of the table's text

 private:
  std::vector<field::LabelName> entries_;
  std::string hash_;
};

// Returns the table that belongs to a label map by its name or folder; nothing if there is none. The first of these
// that exists, for a file NAME.EXTENSION: NAME.ctbl, NAME_ColorTable.ctbl, NAME_LUT.txt, and the only *.ctbl in its
// folder.
[[nodiscard]] std::optional<std::filesystem::path> find_label_table(const std::filesystem::path& label_map);

// Returns the sRGB color, each channel from 0 to 1, of a label without a table entry. Consecutive labels get very
// different hues.
[[nodiscard]] glm::dvec3 default_label_color(std::int64_t label);

}  // namespace isoextract::volume_io
