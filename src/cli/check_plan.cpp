#include "cli/check_plan.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/plan_parts.hpp"
#include "convert/output_checks.hpp"

namespace isoextract::cli {

Result<CheckPlan> plan_check(const CheckFlags& flags) {
  if (flags.meshes.size() != 1) {
    return refuse_usage(fmt::format("expected one mesh, found {}{}{}", flags.meshes.size(),
                                    flags.meshes.empty() ? "" : ": ", fmt::join(flags.meshes, ", ")),
                        "isoextract check MESH");
  }
  if (flags.report) {
    files::InputFileSet read;
    convert::add_read_mesh(read, flags.meshes.front(), Context(plan_memory(flags.memory_limit)));
    if (auto checked = convert::check_output_file(*flags.report, read); !checked) {
      if (checked.error().code == ErrorCode::usage) checked.error().hint = "choose another name with --report";
      return tl::unexpected(checked.error());
    }
  }
  CheckPlan plan;
  plan.mesh = flags.meshes.front();
  plan.weld = flags.weld;
  plan.required = flags.required.value_or(std::vector<check::Requirement>());
  plan.report = flags.report;
  plan.memory = plan_memory(flags.memory_limit);
  plan.json = flags.json;
  return plan;
}

}  // namespace isoextract::cli
