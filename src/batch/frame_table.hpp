// The frames of a batch as a table, for spreadsheets and scripts.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/words.hpp"
#include "batch/frame_record.hpp"

namespace isoextract::batch {

enum class FrameStatus {
  done,
  empty,  // done, and without a triangle
  kept,   // from an earlier run
  failed,
  cancelled,    // it was in work when something else has ended the batch
  not_started,  // a failure, or somebody, has ended the batch before
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
  std::vector<std::string> outputs;  // that were written
  std::string error;                 // why it failed
};

// The first file of a surface of the row, null where it has none; of an animation, whose frames have no files of their
// own, the file that plays them.
[[nodiscard]] std::string output_of(const FrameRow& row, const SurfaceFigures* surface);

// Whether there are surfaces and none has a triangle.
[[nodiscard]] bool is_empty(const FrameFigures& figures);

// RFC 4180, with a header, one row a surface, or a row for each file of a surface whose pieces have files of their own
// (rows_of()); a frame without any has one row, whose iso is empty. Columns: frame,
// input, output (the first file of the row), status (`empty` for a surface without a triangle), iso, asked (auto,
// p99, ...; empty where that was the number), triangles, vertices, area, volume, closed, components, seconds, memory,
// bytes (of the row's files), error, time_step, and in voxels error_rms, error_max (from the mesh to the surface of
// the data), coverage_rms, coverage_max (from that to the mesh), grid where there are several, lacked_attributes
// (the optional ones that the input does not have, a space between two), and unit (of the lengths that area and volume
// are made of). Cells of what is not known are empty. Seconds, memory, time step, attributes and unit are the frame's
// and stand in each of its rows.
[[nodiscard]] std::string table_csv(std::span<const FrameRow> rows);

// A list of the frames, each with the list of its surfaces, or of the files of their pieces; what is not known is null.
[[nodiscard]] convert::Json table_json(std::span<const FrameRow> rows);

}  // namespace isoextract::batch
