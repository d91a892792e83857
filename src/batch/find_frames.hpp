// From what was given as inputs to the frames of a run: which number each has, and which input. Folders are read; no
// file is opened.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "batch/frame_range.hpp"

namespace isoextract::batch {

struct Frame {
  std::int64_t number = 0;
  std::string input;                 // a path or demo:NAME, as read_volume() takes it
  std::optional<std::int64_t> step;  // one of several time steps in that file, where they are frames

  friend bool operator==(const Frame&, const Frame&) = default;
};

struct Frames {
  std::vector<Frame> frames;       // at least one; numbers rise, and none is there twice
  std::vector<FrameRun> gaps;      // with a range: what of it is not there; else what the numbering leaves out
  std::vector<std::string> notes;  // what was decided, one sentence each, fit for a terminal
};

// What of the range is not among the frames, whose numbers rise.
[[nodiscard]] std::vector<FrameRun> gaps_of(const FrameRange& range, std::span<const Frame> frames);

// `inputs` are one of these:
//   a pattern     the files that match it (frame_pattern.hpp); a file that has the pattern for a name is that file
//   demo:NAME     with a pattern in it: one input a number of `range`, which then must be there
//   a folder      the files in it, but for hidden ones, that a volume format reads by extension: one sequence, or files
//                 without one, in natural order
//   other files   as shells expand them; one that does not exist is a frame all the same, and fails when it is read
//
// Files are numbered by the one group of digits in which their names differ (detail/sequences.hpp), or else, with a
// note, 1 to n: by the value of the one decimal number in which they differ (detail/decimal_names.hpp), or in their
// order; a single one by the last digits of its name, or else 1. Where frames are two or more
// apart throughout (1, 3, 7), only multiples of that count as gaps (5). Without `range` all frames are taken, with it
// those that it has.
//
// Fails with ErrorCode::input where a folder cannot be read, where no frame is found, and where two files have one
// number (f_1.vdb and f_01.vdb); with ErrorCode::usage where a folder holds several sequences, which are listed, where
// one file is given twice, where a pattern or a folder is one of several inputs, where the number of a pattern is a
// part of decimal numbers (t_0.{}.vdb with t_0.25.vdb and t_0.5.vdb), for a range of a single file, and for more than
// kMaxFrames frames.
[[nodiscard]] Result<Frames> find_frames(std::span<const std::string> inputs, const std::optional<FrameRange>& range);

}  // namespace isoextract::batch
