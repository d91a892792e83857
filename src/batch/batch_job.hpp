// Many conversions as one value: the frames of a sequence.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "convert/conversion_job.hpp"
#include "particle_io/particle_format.hpp"

namespace isoextract::batch {

struct FrameJob {
  std::int64_t number = 0;  // the frame's number
  convert::ConversionJob job;

  friend bool operator==(const FrameJob&, const FrameJob&) = default;
};

// One file that plays all frames (mesh_io/animation_writer.hpp).
struct AnimationJob {
  std::string path;
  double frames_per_second = 24;
  // When each frame starts, in seconds, ascending from 0; empty: frame numbers decide (mesh_io/animation_writer.hpp).
  std::vector<double> starts = {};

  friend bool operator==(const AnimationJob&, const AnimationJob&) = default;
};

// Returns AnimationJob::starts from the times of the frames. Scales the times so that the first and the last frame
// start as they do by their numbers: `frames_per_second` stays the mean rate. Returns an empty list for fewer than
// three frames, if a frame has no time, or if the times do not ascend. Also returns an empty list if the frames'
// numbers give the same starts within a thousandth of a frame. `numbers` ascend.
[[nodiscard]] std::vector<double> animation_starts(std::span<const std::int64_t> numbers,
                                                   std::span<const particle_io::FrameTime> times,
                                                   double frames_per_second);

struct BatchJob {
  std::vector<FrameJob> frames;           // ordered by number; without `animation`, no two write the same file
  std::optional<AnimationJob> animation;  // if set, each frame has one output, with the animation's path

  friend bool operator==(const BatchJob&, const BatchJob&) = default;
};

// Returns the files that a frame writes. Of an output split into bodies, returns only the first body's files. Names of
// label files keep their placeholders {label} and {name}, so they name no files: ExistingFiles finds those that exist.
[[nodiscard]] std::vector<std::filesystem::path> files_of(const convert::ConversionJob& job);

// Returns 32 hexadecimal digits that identify all frames, their jobs and the animation (see convert::hash_of()).
[[nodiscard]] std::string hash_of(const BatchJob& batch);

struct FrameHash {
  std::int64_t number = 0;
  std::string job;  // convert::hash_of() of the frame's job
};
// Returns hash_of() of the batch with these frames, in order, and without an animation.
[[nodiscard]] std::string hash_of(std::span<const FrameHash> frames);

}  // namespace isoextract::batch
