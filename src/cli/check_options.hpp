// The options of `check`, and what they make: a plan.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/memory_budget.hpp"
#include "cli/options.hpp"
#include "measure/mesh_check.hpp"

namespace isoextract::cli {

struct CheckPlan {
  std::string mesh;
  bool weld = false;
  std::vector<measure::Requirement> required;
  std::optional<std::string> report;
  MemoryBudget memory;
  bool json = false;
};

void declare_check(CLI::App& app, CheckFlags& flags);

// Words of measure::Requirement separated by commas, or "printable" for what a slicer needs; each once.
[[nodiscard]] Result<std::vector<measure::Requirement>> parse_requirements(std::string_view text);

[[nodiscard]] Result<CheckPlan> plan_check(const CheckFlags& flags);

}  // namespace isoextract::cli
