// Many conversions as one value: the frames of a sequence.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "convert/conversion_job.hpp"

namespace isoextract::batch {

struct FrameJob {
  std::int64_t number = 0;  // of the frame
  convert::ConversionJob job;

  friend bool operator==(const FrameJob&, const FrameJob&) = default;
};

struct BatchJob {
  std::vector<FrameJob> frames;  // in the order of their numbers; no two write one file

  friend bool operator==(const BatchJob&, const BatchJob&) = default;
};

// 32 hexadecimal digits that stand for all frames and what is done with them, as convert::hash_of() does for one.
[[nodiscard]] std::string hash_of(const BatchJob& batch);

}  // namespace isoextract::batch
