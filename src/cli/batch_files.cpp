#include "cli/batch_files.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/counted.hpp"
#include "batch/batch_run.hpp"
#include "batch/manifest.hpp"
#include "cli/output_folders.hpp"
#include "cli/output_plan.hpp"
#include "convert/output_checks.hpp"

namespace isoextract::cli {
namespace fs = std::filesystem;

Result<void> make_folders(const BatchPlan& plan) {
  std::vector<fs::path> files;
  for (const std::size_t i : plan.frames) {
    for (const fs::path& file : batch::files_of(plan.batch.frames[i].job)) files.push_back(file);
  }
  // A shard without frames also writes a manifest.
  if (plan.frames.empty()) files.push_back(batch::manifest_folder(plan.batch) / batch::manifest_name(plan.shard));
  return check_or_make_folders(files, plan.make_folders);
}

Result<std::optional<files::InputFileSet>> check_batch_files(const BatchPlan& plan) {
  auto read = TRY(batch::check_written_files(plan.batch, plan.shard, plan.others, plan.common.context));
  const PagesPlan& pages = plan.common.pages;
  for (const std::optional<std::string>* file : std::initializer_list<const std::optional<std::string>*>{
           &plan.flags.table, &plan.flags.plot, &pages.html, &pages.contact_sheet}) {
    if (!*file) continue;
    TRY(convert::check_output_file(**file, read.value_or(files::InputFileSet())));
  }
  return read;
}

std::string units_note(std::span<const batch::FrameRow> rows) {
  std::map<std::string, std::size_t> frames;
  for (const batch::FrameRow& row : rows) {
    if (!row.figures.surfaces.empty()) ++frames[row.figures.unit.empty() ? "unknown" : row.figures.unit];
  }
  if (frames.size() < 2) return {};
  std::vector<std::string> texts;
  for (const auto& [unit, count] : frames) texts.push_back(fmt::format("{} in {}", unit, counted(count, "frame")));
  return fmt::format(
      "the frames have different length units ({}): compare areas and volumes only between rows with the same 'unit'; "
      "--unit file --to-unit mm writes all frames in one unit",
      fmt::join(texts, ", "));
}

}  // namespace isoextract::cli
