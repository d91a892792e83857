// Finds the frames of a run among its inputs: the number and the input of each frame. Lists folders. Opens few files:
//   - of a pattern or folder of pictures two, to see whether they are slices of one volume;
//   - of a folder up to 32 for each plug-in's format, to see whether it is one volume (volume_io::is_volume_folder());
//   - of a folder without volumes, particles and pictures one, to name its format in the error.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/note.hpp"
#include "batch/frame_range.hpp"
#include "particle_io/particle_format.hpp"

namespace isoextract::batch {

struct Frame {
  std::int64_t number = 0;
  std::string input;  // a path or demo:NAME, as read_volume() takes it
  // Not set by find_frames(). If one file holds several frames: the index of the volume or of the frame of particles in
  // it, and the time of that frame.
  std::optional<std::int64_t> volume;
  particle_io::FrameTime time = {};

  friend bool operator==(const Frame&, const Frame&) = default;
};

struct Frames {
  std::vector<Frame> frames;   // at least one, ordered by number, without duplicates
  std::vector<FrameRun> gaps;  // with a range: its numbers without a frame; else the numbers missing between frames
  Notes notes;                 // decisions made, one sentence each, safe to print on a terminal
};

// Returns the numbers of the range without a frame. `frames` are ordered by number.
[[nodiscard]] std::vector<FrameRun> gaps_of(const FrameRange& range, std::span<const Frame> frames);

// Finds the frames. `inputs` are one of these:
//   a pattern     the files that match it (frame_pattern.hpp); if a file has this very name, only that file
//   demo:NAME     with a pattern in it: one input for each number of `range`, which is then required
//   a folder      its files with an extension of a volume format (else of a particle format, else of pictures), but no
//                 hidden files and no samples of a header beside them (scan.raw with scan.nhdr): one sequence, or files
//                 that are no sequence, in natural order
//   a stack       a pattern or folder of single pictures (volume_io::is_slice_stack()): one frame, whose input is the
//                 pattern or folder; with `pictures_are_frames` each picture is a frame
//   other files   a list of paths, one frame each; a missing file is a frame too, which fails when it is read
//
// Numbers of the frames:
//   - If the names differ only in one decimal number (detail/decimal_names.hpp), the frames are numbered 1 to n by its
//     value, with a note: t_0.25 is 1 and t_0.5 is 2.
//   - Otherwise, if they differ in one group of digits (detail/sequences.hpp), that group is the number.
//   - Otherwise they are numbered 1 to n in their order, with a note.
//   - A single file has the last number in its name, else 1.
//
// Gaps are counted at the largest step that divides all differences of the frame numbers: 1, 3 and 7 have the step 2,
// so only 5 is missing. Returns only the frames in `range`; without a range, all frames.
//
// Fails with ErrorCode::input if a folder cannot be read, if there is no frame, and if two files have the same number
// (f_1.vdb and f_01.vdb).
//
// Fails with ErrorCode::usage in these cases:
//   - a folder holds several sequences (the message lists them);
//   - a file is given twice, or one of several inputs is a pattern, a folder, or a word without a point or a slash that
//     names no file;
//   - FramePattern::parse() fails, or a pattern in demo:NAME has no range;
//   - a pattern's number is part of decimal numbers (t_0.{}.vdb with t_0.25.vdb and t_0.5.vdb);
//   - a range is given for a single file, `inputs` is empty, or there are more than kMaxFrames frames.
[[nodiscard]] Result<Frames> find_frames(std::span<const std::string> inputs, const std::optional<FrameRange>& range,
                                         bool pictures_are_frames = false);

// Returns the pattern or the folder if several files are one volume, as a shell lists them for slices/*.png: all
// pictures of a stack, or all files with their extensions of a volume's folder, in any order. Lists their folder, and
// opens files as volume_io::is_slice_stack() and is_volume_folder().
[[nodiscard]] std::optional<std::string> find_one_volume(std::span<const std::string> inputs);

}  // namespace isoextract::batch
