// Merges the manifests of a batch's shards.
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
  std::string absent;  // requested frames without input, as FrameRange text; empty if there are none
};

// Merges the manifests of all shards in `folder` into one, as if one process had run the batch.
//
// A batch may have been run again with another number of shards. Then uses the manifests of the run that has all shards
// and frames, or of the newest run if no run has them all. Skips batches that are merged already. Prefers newer results
// of a later run without shards, which are in the merged manifest. If every batch is merged and the last run had no
// shards (or was shard 1 of 1), only checks the outputs of that run.
//
// Fails with ErrorCode::input, and writes nothing, in these cases:
//   - there is no manifest, or the manifest of a shard is damaged;
//   - a shard or frame is missing or occurs twice;
//   - unmerged manifests are of several batches or program versions;
//   - an output is missing or differs from its record.
//
// Fails with ErrorCode::output if the merged manifest is in use or cannot be written.
[[nodiscard]] Result<MergedShards> merge_shards(const std::filesystem::path& folder);

// Fails with ErrorCode::output if a run of this shard would replace a manifest of this program version that still has
// records of another batch. Merged records do not count, nor do records whose existing files are all among `files`: the
// normalized paths of the existing files that the batch writes. Never fails for a run without shards.
[[nodiscard]] Result<void> check_replaced_shard(const std::filesystem::path& folder, const BatchJob& batch,
                                                const Shard& shard, const std::unordered_set<std::string>& files);

}  // namespace isoextract::batch
