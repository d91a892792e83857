// A batch on several machines: each takes every N-th frame, so that all have their part of a sequence that grows.
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
  int number = 1;  // from 1
  int count = 1;

  [[nodiscard]] bool is_all() const { return count == 1; }
  friend bool operator==(const Shard&, const Shard&) = default;
};

// What was asked for: a shard, or the one that a job scheduler says.
struct ShardChoice {
  std::optional<Shard> shard;  // none: shard_of_environment()

  friend bool operator==(const ShardChoice&, const ShardChoice&) = default;
};

// "2/3" or "auto". Fails with ErrorCode::usage.
[[nodiscard]] Result<ShardChoice> parse_shard(const std::string& text);

// What a job scheduler says of this process, by the variables of its environment: of an array of Slurm
// (SLURM_ARRAY_TASK_ID, _MIN, _COUNT, _STEP) or an indexed job of Kubernetes (JOB_COMPLETION_INDEX, with
// JOB_COMPLETIONS, which its author has to set). None where there is none; fails with ErrorCode::usage where they make
// no sense. `get` is std::getenv. Nobody but who asked for it may take a part of the frames: a job of one task that
// converts a whole sequence has these variables as well.
[[nodiscard]] Result<std::optional<Shard>> shard_of_environment(const std::function<const char*(const char*)>& get);

// The variable that says that this process is one of several; empty where none does.
[[nodiscard]] std::string scheduler_variable(const std::function<const char*(const char*)>& get);

// The shard's frames, by index, in their order.
[[nodiscard]] std::vector<std::size_t> frames_of(const BatchJob& batch, const Shard& shard);

}  // namespace isoextract::batch
