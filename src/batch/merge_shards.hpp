// What the shards of a batch did, joined.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <unordered_set>

#include "base/error.hpp"
#include "batch/batch_job.hpp"
#include "batch/shard.hpp"

namespace isoextract::batch {

struct MergedShards {
  std::filesystem::path manifest;
  int shards = 0;
  std::uint64_t frames = 0;
  std::string absent;  // frames that were asked for and have no input: FrameRange text; empty where there are none
};

// Joins the manifests of all shards in `folder` to one, as a run of one process would have written it. Of one batch in
// other numbers of shards, joins those that have all frames, or else the newest; leaves out batches that are joined
// already. Takes from the joined manifest what a later run without shards made of the batch. Where every shard is
// joined and the last run had none (or was shard 1 of 1), checks that run. Fails with ErrorCode::input where a shard or
// a frame is missing or there twice, where manifests are of several batches or versions of the program, or where an
// output is not what its record says; then nothing is written.
[[nodiscard]] Result<MergedShards> merge_shards(const std::filesystem::path& folder);

// Fails with ErrorCode::output where a run of the shard would replace a manifest with records of another batch that are
// in no other one: of frames that are not joined and whose files are there and are not among `files`, the normal paths
// of those that the batch writes.
[[nodiscard]] Result<void> check_replaced_shard(const std::filesystem::path& folder, const BatchJob& batch,
                                                const Shard& shard, const std::unordered_set<std::string>& files);

}  // namespace isoextract::batch
