// `isoextract merge`: joins the shards of a batch.
#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/printable.hpp"
#include "batch/frame_range.hpp"
#include "batch/merge_shards.hpp"
#include "cli/command.hpp"
#include "cli/messages.hpp"
#include "cli/options/run.hpp"

namespace isoextract::cli {
namespace {

struct MergeFlags : OptionSet {
  Value<std::string> folder{in(OptionGroup::input), "FOLDER", "FOLDER", parse_text,
                            "Output folder with the manifests of the shards."};
  RunFlags run{*this, RunFlags::Taken::quiet};
};

class MergeCommand final : public CommandOf<MergeFlags> {
 public:
  MergeCommand() : CommandOf({"merge", "FOLDER", "Join the manifests of the shards of a batch."}) {}

  // Fails with ErrorCode::frames if all shards are done but requested frames have no input.
  Result<int> run(const std::vector<std::string>& /*arguments*/) override {
    if (!flags().folder || flags().folder->empty()) {
      return fail(ErrorCode::usage, "merge needs the output folder of the shards", "isoextract merge FOLDER");
    }
    const auto merged = TRY(batch::merge_shards(*flags().folder));
    Messages({flags().run.quiet ? Verbosity::quiet : Verbosity::normal})
        .summary(fmt::format("{}: {} of {}{}", printable(merged.manifest.string()), counted(merged.frames, "frame"),
                             counted(merged.shards, "shard"), merged.absent.empty() ? ", complete" : ""));
    if (merged.absent.empty()) return kDone;
    const auto absent = TRY(batch::FrameRange::parse(merged.absent));
    const bool is_one = absent.count() == 1;
    return fail(ErrorCode::frames,
                fmt::format("{} requested frame{} {} no input: {}", absent.count(), is_one ? "" : "s",
                            is_one ? "has" : "have", batch::text_of(absent.runs(), batch::kShownFrameRuns)),
                "add the files and run the shards again with --resume; to allow missing frames, add --missing note to "
                "that run");
  }
};

}  // namespace

std::unique_ptr<Command> make_merge_command() { return std::make_unique<MergeCommand>(); }

}  // namespace isoextract::cli
