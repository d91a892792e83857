#include "cli/batch_dry_run.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/task_arena.h>

#include "base/byte_size.hpp"
#include "base/counted.hpp"
#include "base/printable.hpp"
#include "batch/batch_run.hpp"
#include "batch/frame_range.hpp"
#include "batch/manifest.hpp"
#include "batch/scheduler.hpp"
#include "convert/conversion_size.hpp"
#include "files/output_file.hpp"

namespace isoextract::cli {
namespace {

namespace fs = std::filesystem;

// Returns 0 if the input is not a file.
std::uint64_t size_of_input(const batch::FrameJob& frame) {
  std::error_code none;
  const std::uintmax_t size = fs::file_size(frame.job.source.input, none);
  return none ? 0 : size;
}

// Returns the indices of the frames for the memory estimate: the first, the middle and the last of the frames with the
// largest inputs.
std::vector<std::size_t> sampled_frames(const BatchPlan& plan) {
  std::uint64_t largest = 0;
  std::vector<std::size_t> of_largest;
  for (const std::size_t i : plan.frames) {
    const std::uint64_t size = size_of_input(plan.batch.frames[i]);
    if (size > largest) of_largest.clear();
    largest = std::max(largest, size);
    if (size == largest) of_largest.push_back(i);
  }
  if (of_largest.size() <= 3) return of_largest;
  return {of_largest.front(), of_largest[of_largest.size() / 2], of_largest.back()};
}

struct FrameMemory {
  std::int64_t frame = 0;
  std::uint64_t bytes = 0;
};

// Returns "memory: about 118 MiB (117 MiB for frame 3, 1 at a time; largest of the estimates for frames 0, 2, 3)".
Result<std::string> memory_text(const BatchPlan& plan, const Messages& messages) {
  std::vector<std::int64_t> estimated;
  std::optional<FrameMemory> most;
  std::optional<Error> failed;
  const std::size_t at_once = std::min(static_cast<std::size_t>(plan.jobs), plan.frames.size());
  tbb::task_arena arena(batch::threads_of_one(plan.threads, at_once));
  for (const std::size_t i : sampled_frames(plan)) {
    const batch::FrameJob& frame = plan.batch.frames[i];
    const auto use = plan.batch.animation     ? convert::MeshUse::whole
                     : plan.measures_meshes() ? convert::MeshUse::figures
                                              : convert::MeshUse::none;
    const auto bytes =
        arena.execute([&] { return convert::estimated_memory(frame.job, use, plan.common.context.memory()); });
    if (!bytes) {
      if (!failed) failed = bytes.error();
      messages.note({NoteId::memory_unknown, fmt::format("frame {}: the dry run cannot estimate the memory: {}",
                                                         frame.number, bytes.error().message)});
      continue;
    }
    estimated.push_back(frame.number);
    if (!most || *bytes > most->bytes) most = FrameMemory{frame.number, *bytes};
  }
  if (!most) return tl::unexpected(std::move(*failed));
  constexpr std::uint64_t kMiB = 1 << 20;
  const std::string sampled = fmt::format("; largest of the estimates for frames {}", fmt::join(estimated, ", "));
  return fmt::format("memory: about {} MiB ({} for frame {}, {} at a time{})\n",
                     (most->bytes * at_once + kMiB - 1) / kMiB, format_byte_size(most->bytes), most->frame, at_once,
                     estimated.size() > 1 ? sampled : "");
}

}  // namespace

Result<void> print_batch_plan(const BatchPlan& plan, const Messages& messages) {
  std::string text;
  std::uint64_t bytes = 0;
  std::unordered_set<std::string> counted;  // inputs counted so far: many frames can be volumes of one file
  for (const std::size_t i : plan.frames) {
    const batch::FrameJob& frame = plan.batch.frames[i];
    const std::string& input = frame.job.source.input;
    std::error_code none;
    const std::uintmax_t size = fs::file_size(input, none);
    if (!none && counted.insert(input).second) bytes += size;
    for (const convert::OutputFileJob& output : frame.job.outputs) {
      text += fmt::format("frame {}: {}{} -> {}{}\n", frame.number, printable(input),
                          none ? "" : fmt::format(" ({})", format_byte_size(size)), printable(output.path),
                          files::is_there(output.path) ? " (exists)" : "");
    }
  }
  text += fmt::format(
      "frames: {}, {} of inputs; {}\n", plan.frames.size(), format_byte_size(bytes),
      plan.gaps.empty() ? "no gaps" : fmt::format("missing: {}", batch::text_of(plan.gaps, batch::kShownFrameRuns)));
  if (plan.batch.animation) {
    text += fmt::format("animation: {}, {} per second\n", printable(plan.batch.animation->path),
                        isoextract::counted(plan.batch.animation->frames_per_second, "frame"));
  }
  text += fmt::format("jobs: {} at a time\n", plan.jobs);
  text += fmt::format("manifest: {}\n",
                      printable((batch::manifest_folder(plan.batch) / batch::manifest_name(plan.shard)).string()));
  if (!plan.frames.empty()) {
    const auto memory = TRY(memory_text(plan, messages));
    text += memory;
  }
  for (const Note& note : plan.common.notes) messages.note(note);
  return print_to_stdout(text);
}

}  // namespace isoextract::cli
