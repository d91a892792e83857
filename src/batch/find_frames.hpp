// Finds the frames of a run among its inputs: the number and the input of each frame. Lists folders. Opens few files:
//   - two of a pattern or folder of pictures, to find out whether they are slices of one volume;
//   - up to 32 of a folder for each plug-in's format, to find out whether the folder is one volume
//     (volume_io::is_volume_folder());
//   - one of a folder without volumes, particles, pictures and meshes, to name the file's format in the error.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "base/note.hpp"
#include "batch/frame_range.hpp"
#include "particle_io/particle_format.hpp"

namespace isoextract::batch {

struct Frame {
  std::int64_t number = 0;
  std::string input;  // a path or demo:NAME, as read_volume() takes it
  // For a file with several frames: the index of the volume, or of the frame of particles, in the file, and the time of
  // that frame. find_frames() does not set them.
  std::optional<std::int64_t> volume;
  particle_io::FrameTime time = {};

  friend bool operator==(const Frame&, const Frame&) = default;
};

struct Frames {
  std::vector<Frame> frames;   // at least one, ordered by number, without duplicates
  std::vector<FrameRun> gaps;  // with a range: its numbers without a frame; else the numbers missing between frames
  Notes notes;                 // how the inputs were read, one sentence each, safe to print on a terminal
  bool have_numbers = true;    // the names have whole or decimal frame numbers; false: the names do not give the order
};

// Returns the numbers in `range` that have no frame. All `frames` must be in the range, ordered by number.
[[nodiscard]] std::vector<FrameRun> gaps_of(const FrameRange& range, std::span<const Frame> frames);

// Finds the frames. `given` is one of these:
//   a pattern     the files and volume folders that match it (frame_pattern.hpp); if a file has exactly this name, only
//                 that file
//   demo:NAME     with a pattern in it: one input for each number of `range`, which is then required
//   a volume      a folder that is one volume (volume_io::is_volume_folder()): one frame
//   a stack       a pattern or folder of single pictures (volume_io::is_slice_stack()): one frame, whose input is the
//                 pattern or folder; with `pictures_are_frames` each picture is a frame
//   a folder      any other folder: its volume files; without volume files its particle files, else its pictures, else
//                 its meshes, found by extension. The files must be one sequence, or form no sequence and then have
//                 natural order. Ignores hidden files, and sample files with a header (scan.raw with scan.nhdr).
//   other inputs  a list, one frame for each input, without the files that without_sample_files() removes; a missing
//                 file is a frame that fails when it is read
//
// Numbers of the frames:
//   - If the names differ only in one decimal number (detail/decimal_names.hpp), the frames get the numbers 1 to n in
//     the order of its value, with a note: t_0.25 is 1 and t_0.5 is 2.
//   - Otherwise, if the names differ in one group of digits (detail/sequences.hpp), that group is the number.
//   - Otherwise the frames get the numbers 1 to n in the order of the inputs, with a note.
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
//   - a list has a file twice;
//   - a list has slices of one volume, without `pictures_are_frames`;
//   - a list has a pattern, or a folder that is no volume;
//   - a list has a word that names no file and has no period, slash, brace, # or *, like a stray option value;
//   - FramePattern::parse() fails, or a pattern in demo:NAME has no range;
//   - a pattern's number is part of decimal numbers (t_0.{}.vdb with t_0.25.vdb and t_0.5.vdb);
//   - `range` is set for a single file, stack or volume folder;
//   - `given` is empty, or there are more than kMaxFrames frames.
[[nodiscard]] Result<Frames> find_frames(std::span<const std::string> given, const std::optional<FrameRange>& range,
                                         bool pictures_are_frames = false);

// Files of a folder, for a note: their number, and the first name in natural order.
struct CountedFiles {
  std::size_t count = 0;
  std::string first;

  void add(const std::string& name);
};

// Returns the note about the files of a folder that a run takes and those that it skips. `kind` is what it takes, such
// as "volume file"; `pictures` and `others` are the skipped files, at least one of them.
[[nodiscard]] Note note_of_other_files(const std::string& folder, std::string_view kind, const CountedFiles& taken,
                                       const CountedFiles& pictures, const CountedFiles& others);

// Returns the volume whose files are `inputs`, such as a shell's list for slices/*.png: the pattern of a stack, or a
// volume folder. Returns nullopt if the list is incomplete, has one file or several folders, or is several volumes. The
// files may be in any order. Lists the folder, and opens files as is_slice_stack() and is_volume_folder() do.
[[nodiscard]] std::optional<std::string> find_one_volume(std::span<const std::string> inputs);

}  // namespace isoextract::batch
