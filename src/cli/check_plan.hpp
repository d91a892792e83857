// Makes a plan from the options of `check`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/memory_budget.hpp"
#include "cli/options/meshes.hpp"

namespace isoextract::cli {

struct CheckPlan {
  std::string mesh;
  bool weld = false;
  std::vector<check::Requirement> required;
  std::optional<std::string> report;
  MemoryBudget memory;
  bool json = false;
};

// Fails with ErrorCode::usage unless there is one mesh, and as convert::check_output_file() for --report.
[[nodiscard]] Result<CheckPlan> plan_check(const CheckFlags& flags);

}  // namespace isoextract::cli
