// Runs of several processes: finds out from the environment that a launcher started them, and connects them by a
// plug-in (plugins/ranks_plugin.h).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/error.hpp"
#include "base/ranks.hpp"
#include "plugin_host/plugin_library.hpp"

namespace isoextract::plugin_host {

// The rank of this process among the processes that a launcher started.
struct LaunchedRank {
  int rank = 0;
  int size = 1;
  std::string variable;  // the environment variable with the size: "OMPI_COMM_WORLD_SIZE"
};

// Returns nullopt if no launcher of MPI programs started this process, or if the launcher started no other one. Knows
// mpirun of Open MPI (OMPI_COMM_WORLD_SIZE), launchers with PMI (PMI_SIZE), and srun with PMIx (PMIX_RANK,
// SLURM_STEP_NUM_TASKS). `get` is std::getenv, or a replacement in tests.
[[nodiscard]] std::optional<LaunchedRank> launched_rank(const std::function<const char*(const char*)>& get);

// Connects this process with the other ranks and waits for them. Fails with ErrorCode::unavailable if the plug-in is
// missing or cannot connect as many ranks as the launcher started.
[[nodiscard]] Result<std::unique_ptr<RankLink>> join_ranks(const LaunchedRank& launched, PluginFolders folders);

}  // namespace isoextract::plugin_host
