#include "cli/merge_command.hpp"

#include <fmt/format.h>

#include "base/printable.hpp"
#include "batch/frame_range.hpp"
#include "batch/merge_shards.hpp"
#include "cli/messages.hpp"

namespace isoextract::cli {

Result<void> run_merge(const MergeFlags& flags) {
  if (!flags.folder || flags.folder->empty()) {
    return fail(ErrorCode::usage, "merge needs the folder of the shards' outputs", "isoextract merge FOLDER");
  }
  const auto merged = TRY(batch::merge_shards(*flags.folder));
  Messages(flags.run.quiet ? Verbosity::quiet : Verbosity::normal)
      .summary(fmt::format("{}: {} frame{} of {} shard{}{}", printable(merged.manifest.string()), merged.frames,
                           merged.frames == 1 ? "" : "s", merged.shards, merged.shards == 1 ? "" : "s",
                           merged.absent.empty() ? ", all there" : ""));
  if (merged.absent.empty()) return {};
  const auto absent = TRY(batch::FrameRange::parse(merged.absent));
  const bool is_one = absent.count() == 1;
  return fail(ErrorCode::frames,
              fmt::format("{} frame{} asked for and {} no input: {}", absent.count(), is_one ? " was" : "s were",
                          is_one ? "has" : "have", batch::text_of(absent.runs(), batch::kShownFrameRuns)),
              "once their files are there, run the shards again with --resume; with --missing note they are no error");
}

}  // namespace isoextract::cli
