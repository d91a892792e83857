// Whether the surfaces of a file are closed, in words: from their extraction and cuts, and from a count of boundary
// edges where these leave it open.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "convert/conversion_job.hpp"
#include "convert/events.hpp"

namespace isoextract::cli {

class SurfaceEnds {
 public:
  explicit SurfaceEnds(const convert::ConversionJob& job) : job_(job) {}

  // `label` names the field: WrittenOutput::labels.
  void extracted(const std::string& label, const convert::ExtractedSurface& surface);
  void clipped(const std::string& label, double iso, const edit::ClipFacts& facts);

  // "closed", or "open" with the places and the option that closes them.
  [[nodiscard]] std::string text_of(const convert::WrittenOutput& output) const;

 private:
  struct End {
    bool at_border = false;  // of the data or the region
    bool cut = false;        // at a plane, and left open there
    bool counted = false;    // its boundary edges are among WrittenOutput::open_edges
    std::uint64_t hole_cells = 0;
  };

  const convert::ConversionJob& job_;
  // By field and iso value: components of a surface are written to several files.
  std::map<std::pair<std::string, double>, End> ends_;
};

}  // namespace isoextract::cli
