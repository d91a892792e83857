// Shards: a batch on several machines. Each of N shards takes every N-th frame, not a block of consecutive frames:
// later frames of a growing sequence cost more, so blocks would take unequal time.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "batch/batch_job.hpp"

namespace isoextract::batch {

struct Shard {
  int number = 1;  // counted from 1
  int count = 1;

  [[nodiscard]] bool is_all() const { return count == 1; }
  friend bool operator==(const Shard&, const Shard&) = default;
};

// The requested shard: given, or to be taken from the job scheduler's environment.
struct ShardChoice {
  std::optional<Shard> shard;  // nullopt: use shard_of_environment()

  friend bool operator==(const ShardChoice&, const ShardChoice&) = default;
};

// Parses "2/3" or "auto". Fails with ErrorCode::usage.
[[nodiscard]] Result<ShardChoice> parse_shard(const std::string& text);

// Returns the shard that a job scheduler's environment variables give to this process. Supports Slurm arrays
// (SLURM_ARRAY_TASK_ID, _MIN, _COUNT, _STEP) and indexed jobs of Kubernetes (JOB_COMPLETION_INDEX, with
// JOB_COMPLETIONS, which the author of the job must set). `get` returns the value of a variable, or null if it is not
// set, as std::getenv() does.
//
// Returns nullopt without such variables. Fails with ErrorCode::usage if the count is missing, a variable is no whole
// number, or the variables are inconsistent. Call only for --shard auto: array tasks that each convert a whole
// sequence have these variables, too.
[[nodiscard]] Result<std::optional<Shard>> shard_of_environment(const std::function<const char*(const char*)>& get);

// Returns the name of the job scheduler's environment variable that holds this task's number, such as
// "SLURM_ARRAY_TASK_ID"; empty if none is set.
[[nodiscard]] std::string scheduler_variable(const std::function<const char*(const char*)>& get);

// Returns the indices of the shard's frames, in order.
[[nodiscard]] std::vector<std::size_t> frames_of(const BatchJob& batch, const Shard& shard);

}  // namespace isoextract::batch
