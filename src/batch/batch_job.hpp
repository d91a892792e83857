// Many conversions as one value: the frames of a sequence.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "convert/conversion_job.hpp"

namespace isoextract::batch {

struct FrameJob {
  std::int64_t number = 0;  // of the frame
  convert::ConversionJob job;

  friend bool operator==(const FrameJob&, const FrameJob&) = default;
};

// All frames in one file that plays them (mesh_io/animation_writer.hpp).
struct AnimationJob {
  std::string path;
  double frames_per_second = 24;

  friend bool operator==(const AnimationJob&, const AnimationJob&) = default;
};

struct BatchJob {
  std::vector<FrameJob> frames;           // in the order of their numbers; no two write one file
  std::optional<AnimationJob> animation;  // then each frame has one output, with this path

  friend bool operator==(const BatchJob&, const BatchJob&) = default;
};

// The files that a frame writes. Of pieces, of which there may be any number, the first.
[[nodiscard]] std::vector<std::filesystem::path> files_of(const convert::ConversionJob& job);

// 32 hexadecimal digits that stand for all frames and what is done with them, as convert::hash_of() does for one.
[[nodiscard]] std::string hash_of(const BatchJob& batch);

// The same, of a batch without an animation, from the number and convert::hash_of() of each frame, in their order.
struct FrameHash {
  std::int64_t number = 0;
  std::string job;
};
[[nodiscard]] std::string hash_of(std::span<const FrameHash> frames);

}  // namespace isoextract::batch
