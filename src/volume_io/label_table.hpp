// What the labels of a label map are called, and their colours.
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
  glm::dvec3 colour{0.0};  // as screens show it (sRGB), each channel from 0 to 1

  friend bool operator==(const LabelEntry&, const LabelEntry&) = default;
};

class LabelTable {
 public:
  static constexpr std::uint64_t kMaxBytes = std::uint64_t{16} << 20;  // of a file

  // A line a label, of either kind; what follows a # at the start of a line is a comment.
  //
  //   number red green blue alpha visible mesh "name"    ITK-SNAP's label descriptions
  //   number name red green blue alpha                   FreeSurfer's look-up tables, and 3D Slicer's
  //
  // Colours are whole numbers from 0 to 255. What alpha means differs between those who write such tables, and what is
  // visible is for a viewer: both are read past. Fails with ErrorCode::input where a line is anything else, with its
  // number; where a label comes twice; and where there is none. `source` starts the message.
  [[nodiscard]] static Result<LabelTable> parse(std::string_view text, const std::string& source);

  // Of a file; fails also where it cannot be read or is larger than kMaxBytes.
  [[nodiscard]] static Result<LabelTable> read(const std::string& path, const Context& context);

  [[nodiscard]] const std::vector<LabelEntry>& entries() const { return entries_; }  // by label, rising
  // Null where there is none.
  [[nodiscard]] const LabelEntry* find(std::int64_t label) const;
  // Whether another label has its name, too.
  [[nodiscard]] bool shares_name(const LabelEntry& entry) const;
  [[nodiscard]] const std::string& hash() const { return hash_; }  // of the text

 private:
  std::vector<LabelEntry> entries_;
  std::string hash_;
};

// The colour of a label that no table has one for: hues far apart for numbers that follow each other.
[[nodiscard]] glm::dvec3 usual_label_colour(std::int64_t label);

}  // namespace isoextract::volume_io
