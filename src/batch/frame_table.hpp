// The table of a batch's frames, for spreadsheets and scripts.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/enum_words.hpp"
#include "batch/frame_record.hpp"

namespace isoextract::batch {

enum class FrameStatus {
  done,
  empty,  // done, but no surface has a triangle
  kept,   // from an earlier run
  failed,
  cancelled,    // running when the batch ended for another reason
  not_started,  // the batch ended before, by a failure or by request
};
constexpr auto words_of(FrameStatus /*type*/) {
  return std::array{Word{FrameStatus::done, "done"},           Word{FrameStatus::empty, "empty"},
                    Word{FrameStatus::kept, "kept"},           Word{FrameStatus::failed, "failed"},
                    Word{FrameStatus::cancelled, "cancelled"}, Word{FrameStatus::not_started, "not started"}};
}

struct FrameRow {
  std::int64_t frame = 0;
  std::string input;
  FrameStatus status = FrameStatus::not_started;
  FrameFigures figures;
  std::vector<std::string> outputs;  // files that were written, or that the record of a kept frame lists
  std::string error;                 // why the frame failed
  std::optional<int> rank = {};      // the rank that converted the frame, if the run has several (base/ranks.hpp)
};

// Returns the first file of a surface of the row. For a row without surfaces (`surface` is null), and for an animation,
// whose frames have no files of their own, returns the row's first file. Empty if there is no file.
[[nodiscard]] std::string output_of(const FrameRow& row, const SurfaceFigures* surface);

// Returns whether there are surfaces but none has a triangle.
[[nodiscard]] bool is_empty(const FrameFigures& figures);

// Returns the frames as CSV (RFC 4180) with a header. There is one row for each surface, or for each file of a surface
// whose bodies have several files (rows_of()). A frame without surfaces has one row with an empty iso value.
//
// Columns:
//   frame, input, output           `output` is the first file of the row
//   status                         `empty` for a surface without a triangle
//   iso, asked                     `asked`: auto, p99, ...; empty if a number was given
//   triangles, vertices, area, volume, closed, components
//   seconds, memory, bytes         `bytes` of the row's files
//   error                          why the frame failed
//   step, time                     of a frame of particles, as the file states them
//   error_rms, error_max           in voxels, from the mesh to the data's surface
//   coverage_rms, coverage_max     in voxels, from the data's surface to the mesh
//   grid                           if the frame has several
//   lacked_attributes              optional attributes that the input lacks, separated by spaces
//   unit                           of the lengths in area and volume
//
// Unknown values are empty cells, but seconds, memory and bytes are 0 for a kept frame without a record. Seconds,
// memory, error, step, time, lacked_attributes and unit belong to the frame and repeat in each of its rows.
[[nodiscard]] std::string table_csv(std::span<const FrameRow> rows);

// Returns a frame as an object with a list of its rows_of(). Unknown values are null, or 0 where table_csv() has 0.
// `rank` is there only for a frame that was converted in a run with several ranks.
[[nodiscard]] convert::Json row_json(const FrameRow& row);
// Returns a list of the frames' row_json(), each with the key `schema`: the name and version of this document.
[[nodiscard]] convert::Json table_json(std::span<const FrameRow> rows);

}  // namespace isoextract::batch
