// Makes a self-contained HTML page about a conversion or the frames of a sequence: pictures, the table of frames,
// plots, measured errors, skipped work, times by stage, notes, versions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "batch/frame_table.hpp"
#include "cli/mesh_pictures.hpp"
#include "convert/outcome.hpp"

namespace isoextract::cli {

class HtmlPage {
 public:
  // Adds the data of a frame that its FrameRow lacks: measured errors, times by stage, skipped work, notes, device. Not
  // thread-safe.
  void add(std::int64_t frame, const convert::Outcome& outcome);

  // Draws the pictures and returns the page. `rows` has all frames; a frame without add() shows only its row. `svg` is
  // the plot over the frames, or empty. `arguments` are the words of the command line without the program's name.
  // Fails as MeshPictures::draw(), image_io::encode_png() and Context::check() do.
  [[nodiscard]] Result<std::string> text(std::span<const batch::FrameRow> rows, const MeshPictures& pictures,
                                         const std::string& svg, const std::vector<std::string>& arguments,
                                         const Context& context) const;

 private:
  // The distance of a mesh from its isosurface, measured at points inside the triangles.
  struct MeasuredError {
    std::int64_t frame = 0;
    std::string grid;  // set if there are several grids
    double iso = 0;
    double rms = 0;      // in world units
    double largest = 0;  // in world units
    double voxels = 0;   // the largest error in voxels
  };
  // Facts about done or skipped work of one topic and action, summed over all frames.
  struct SkippedWork {
    std::uint64_t count = 0;
    std::uint64_t total = 0;
    std::size_t times = 0;  // the number of facts
    std::string first;      // the text of the first fact
  };

  [[nodiscard]] std::string left_out_section() const;
  [[nodiscard]] std::string error_section() const;
  [[nodiscard]] std::string stage_section() const;

  std::vector<MeasuredError> errors_;
  std::map<std::pair<std::string, std::string>, SkippedWork> left_out_;  // by topic and action
  std::map<std::string, double> stages_;                                 // seconds, summed over all frames
  std::set<std::string> devices_;
  std::vector<std::pair<std::int64_t, Note>> notes_;
};

}  // namespace isoextract::cli
