#include "cli/batch_files.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "batch/manifest.hpp"
#include "batch/merge_shards.hpp"
#include "cli/output_folders.hpp"
#include "cli/output_plan.hpp"
#include "convert/output_checks.hpp"

namespace isoextract::cli {
namespace {

namespace fs = std::filesystem;

files::ReadFiles read_files_of(const BatchPlan& plan) {
  files::ReadFiles read;
  for (const batch::NamedFile& file : plan.others.read) read.add(file.path, file.what);
  const convert::SourceOptions* before = nullptr;
  for (const batch::FrameJob& frame : plan.batch.frames) {
    const convert::SourceOptions& source = frame.job.source;
    // The volumes of one file are many frames.
    const bool is_known = before != nullptr && before->input == source.input && before->attributes == source.attributes;
    if (!is_known) convert::add_read_files(read, frame.job, Context());
    before = &source;
  }
  return read;
}

}  // namespace

Result<void> make_folders(const BatchPlan& plan) {
  std::vector<fs::path> files;
  for (const std::size_t i : plan.frames) {
    for (const fs::path& file : files_of(plan.batch.frames[i].job)) files.push_back(file);
  }
  // A shard without frames has a manifest all the same.
  if (plan.frames.empty()) files.push_back(plan.folder / batch::manifest_name(plan.shard));
  return see_to_folders(files, plan.make_folders);
}

Result<std::optional<files::ReadFiles>> check_batch_files(const BatchPlan& plan) {
  std::vector<fs::path> there;  // of all that is written
  std::unordered_set<std::string> meshes;
  for (const batch::FrameJob& frame : plan.batch.frames) {
    for (fs::path& file : files_of(frame.job)) {
      meshes.insert(file.lexically_normal().string());
      if (is_there(file)) there.push_back(std::move(file));
    }
  }
  TRY(batch::check_replaced_shard(plan.folder, plan.batch, plan.shard, meshes));
  for (const batch::NamedFile& file : plan.others.written) {
    if (is_there(file.path)) there.emplace_back(file.path);
  }
  std::optional<files::ReadFiles> read;
  if (plan.common.job.pieces.split || !there.empty()) read = read_files_of(plan);
  for (const fs::path& file : there) {
    TRY(read->check(file));
  }
  const PagesPlan& pages = plan.common.pages;
  for (const std::optional<std::string>* file : std::initializer_list<const std::optional<std::string>*>{
           &plan.flags.table, &plan.flags.plot, &pages.html, &pages.contact_sheet}) {
    if (!*file) continue;
    TRY(convert::check_output_file(**file, read.value_or(files::ReadFiles())));
  }
  return read;
}

std::string note_of_units(std::span<const batch::FrameRow> rows) {
  std::map<std::string, std::size_t> frames;
  for (const batch::FrameRow& row : rows) {
    if (!row.figures.surfaces.empty()) ++frames[row.figures.unit.empty() ? "unknown" : row.figures.unit];
  }
  if (frames.size() < 2) return {};
  std::vector<std::string> texts;
  for (const auto& [unit, count] : frames) texts.push_back(fmt::format("{} in {} of them", unit, count));
  return fmt::format(
      "the frames have lengths in unlike units ({}): their areas and volumes compare only where the column 'unit' is "
      "the "
      "same; --unit file --to-unit mm writes all in one",
      fmt::join(texts, ", "));
}

}  // namespace isoextract::cli
