// What the shards of a batch did, joined.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "base/error.hpp"

namespace isoextract::batch {

struct MergedShards {
  std::filesystem::path manifest;
  int shards = 0;
  std::uint64_t frames = 0;
  std::string absent;  // frames that were asked for and have no input: FrameRange text; empty where there are none
};

// Joins the manifests of all shards in `folder` to one, as a run of one process would have written it. Of one batch in
// other numbers of shards, joins those that have all frames, or else the newest; leaves out batches that are joined
// already. Fails with ErrorKind::input where a shard or a frame is missing or there twice, where manifests are of
// several batches or versions of the program, or where an output is not what its record says; then nothing is written.
[[nodiscard]] Result<MergedShards> merge_shards(const std::filesystem::path& folder);

}  // namespace isoextract::batch
