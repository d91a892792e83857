#include "batch/merge_shards.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <system_error>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/counted.hpp"
#include "base/version.hpp"
#include "batch/detail/animation.hpp"
#include "batch/frame_range.hpp"
#include "batch/manifest.hpp"

namespace isoextract::batch {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> bad(const fs::path& path, const std::string& what, Hint hint = {}) {
  return fail(ErrorCode::input, fmt::format("{}: {}", path.string(), what), std::move(hint));
}

struct ShardManifest {
  fs::path path;
  ManifestContent content;
};

// The manifests of one batch with one number of shards.
struct ShardGroup {
  std::vector<ShardManifest> shards;                       // sorted by path; at least one
  fs::file_time_type written = fs::file_time_type::min();  // latest write time

  [[nodiscard]] const ManifestHeader& header() const { return shards.front().content.header; }
  [[nodiscard]] bool is_of_batch(const ManifestHeader& other) const {
    return header().batch == other.batch && header().program == other.program;
  }
  [[nodiscard]] std::uint64_t records() const {
    std::uint64_t count = 0;
    for (const ShardManifest& shard : shards) count += shard.content.records.size();
    return count;
  }
  [[nodiscard]] bool is_complete() const {
    return static_cast<int>(shards.size()) == header().shard.count && records() == header().frames;
  }
  [[nodiscard]] std::vector<std::string> paths() const {
    std::vector<std::string> names;
    for (const ShardManifest& shard : shards) names.push_back(shard.path.string());
    return names;
  }
};

// The manifest of runs without shards and of earlier merges.
class JoinedManifest {
 public:
  explicit JoinedManifest(const fs::path& folder) : path_(folder / manifest_name({})) {
    auto content = read_manifest(path_);  // a damaged one fails in Manifest::open()
    if (!content || content->header.program != generator()) return;
    content_ = std::move(*content);
    for (const FrameRecord& record : content_.records) {
      by_job_[record.job] = &record;
      by_frame_[record.frame] = &record;
    }
  }
  JoinedManifest(const JoinedManifest&) = delete;
  JoinedManifest& operator=(const JoinedManifest&) = delete;

  [[nodiscard]] const fs::path& path() const { return path_; }
  // The header of the last run or merge; its `batch` is empty if there is no such manifest.
  [[nodiscard]] const ManifestHeader& header() const { return content_.header; }
  [[nodiscard]] bool is_there() const { return !content_.header.batch.empty(); }
  [[nodiscard]] const FrameRecord* find(const std::string& job) const {
    const auto place = by_job_.find(job);
    return place == by_job_.end() ? nullptr : place->second;
  }
  // Returns the last record of a frame, of any batch.
  [[nodiscard]] const FrameRecord* last_of(std::int64_t frame) const {
    const auto place = by_frame_.find(frame);
    return place == by_frame_.end() ? nullptr : place->second;
  }

 private:
  fs::path path_;
  ManifestContent content_;
  std::unordered_map<std::string, const FrameRecord*> by_job_;
  std::unordered_map<std::int64_t, const FrameRecord*> by_frame_;
};

// The records that count: all, or only those whose inputs and outputs are unchanged.
enum class Wanted { all, unchanged };

// Adds records of the joined manifest, which may be of other batches, for the frames that `found` lacks. Adds none if
// all frames together are another batch, or if frames are missing and the last run or merge was another batch.
void add_joined_records(const ManifestHeader& header, const JoinedManifest& joined, Wanted wanted,
                        std::map<std::int64_t, FrameRecord>& found) {
  const auto range = FrameRange::parse(header.numbers);
  if (!joined.is_there() || !range) return;
  std::map<std::int64_t, FrameRecord> filled = found;
  for (const std::int64_t number : range->numbers()) {
    const FrameRecord* const record = filled.contains(number) ? nullptr : joined.last_of(number);
    if (record == nullptr || (wanted == Wanted::unchanged && !changed_file_message(*record).empty())) continue;
    filled.emplace(number, *record);
  }
  std::vector<FrameHash> frames;
  for (const auto& [number, record] : filled) frames.push_back({number, record.job});
  const bool is_whole = frames.size() == header.frames;
  const bool is_of_batch = is_whole ? hash_of(frames) == header.batch : joined.header().batch == header.batch;
  if (is_of_batch) found = std::move(filled);
}

Result<std::vector<ShardGroup>> read_groups(const fs::path& folder) {
  auto paths = TRY(manifest_paths(folder));
  std::erase_if(paths, [](const fs::path& path) { return path.filename() == manifest_name({}); });
  std::vector<ShardGroup> groups;
  for (const fs::path& path : paths) {
    auto content = TRY(read_manifest(path));
    const Shard& shard = content.header.shard;
    if (shard.number < 1 || shard.number > shard.count) return bad(path, "the manifest has an invalid shard number");
    auto group = std::ranges::find_if(groups, [&](const ShardGroup& known) {
      return known.is_of_batch(content.header) && known.header().shard.count == shard.count;
    });
    if (group == groups.end()) group = groups.insert(group, ShardGroup());
    std::error_code none;
    group->written = std::max(group->written, fs::last_write_time(path, none));
    group->shards.push_back({path, std::move(content)});
  }
  return groups;
}

// Returns one group of each batch: the complete one, else the newest.
std::vector<ShardGroup> best_group_per_batch(std::vector<ShardGroup> groups) {
  std::ranges::stable_sort(groups, [](const ShardGroup& a, const ShardGroup& b) {
    return std::pair(a.is_complete(), a.written) > std::pair(b.is_complete(), b.written);
  });
  std::vector<ShardGroup> chosen;
  for (ShardGroup& group : groups) {
    const bool is_new =
        std::ranges::none_of(chosen, [&](const ShardGroup& known) { return known.is_of_batch(group.header()); });
    if (is_new) chosen.push_back(std::move(group));
  }
  return chosen;
}

// Returns whether the joined manifest has all records of the group's batch.
bool is_joined(const ShardGroup& group, const JoinedManifest& joined) {
  std::map<std::int64_t, FrameRecord> found;
  for (const ShardManifest& shard : group.shards) {
    for (const FrameRecord& record : shard.content.records) {
      const FrameRecord* const known = joined.find(record.job);
      if (known == nullptr) return false;
      found.emplace(record.frame, *known);
    }
  }
  add_joined_records(group.header(), joined, Wanted::unchanged, found);
  return found.size() == group.header().frames;
}

// Returns the group to join: of the only batch that is not joined yet. If all are joined, returns the newest, to check
// its files again. Returns nullopt if there is no group.
Result<std::optional<ShardGroup>> choose_group(const fs::path& folder, const JoinedManifest& joined) {
  auto read = TRY(read_groups(folder));
  std::vector<ShardGroup> groups = best_group_per_batch(std::move(read));
  if (groups.empty()) return std::nullopt;
  std::ranges::stable_sort(groups, std::ranges::greater(), &ShardGroup::written);
  if (groups.size() == 1) return std::move(groups.front());
  std::vector<ShardGroup*> open;
  for (ShardGroup& group : groups) {
    if (!is_joined(group, joined)) open.push_back(&group);
  }
  if (open.empty()) return std::move(groups.front());
  if (open.size() == 1) return std::move(*open.front());
  return bad(open.front()->shards.front().path,
             fmt::format("this manifest and {} are of different batches: frames, options or program version differ",
                         open.back()->shards.front().path.string()),
             fmt::format("merge joins one batch at a time: remove the manifests of the batch that you give up, for "
                         "example of the older batch: {}",
                         fmt::join(open.back()->paths(), " ")));
}

// Returns "3 are missing: 2, 5, 8".
std::string missing_text(const ManifestHeader& header, const std::map<std::int64_t, FrameRecord>& found) {
  std::vector<std::int64_t> missing;
  if (const auto range = FrameRange::parse(header.numbers)) {
    for (const std::int64_t number : range->numbers()) {
      if (!found.contains(number)) missing.push_back(number);
    }
  }
  const std::uint64_t count = header.frames - std::min<std::uint64_t>(header.frames, found.size());
  std::string text = fmt::format("{} {} missing", count, count == 1 ? "is" : "are");
  if (!missing.empty()) text += ": " + text_of(runs_of(missing), kShownFrameRuns);
  return text;
}

Result<void> check_outputs(const FrameRecord& record) {
  for (const FileRecord& output : record.outputs) {
    const auto now = TRY(files::hash_file(output.path, Context()));
    if (now.hash != output.state.hash) return bad(output.path, "this file has changed since its shard wrote it");
  }
  return {};
}

std::string absent_text(const ManifestHeader& header) {
  return header.absent.empty() ? "" : fmt::format("; requested frames without input: {}", header.absent);
}

tl::unexpected<Error> fail_missing(const fs::path& folder, const ManifestHeader& header,
                                   const std::map<std::int64_t, FrameRecord>& found) {
  return bad(folder, fmt::format("expected {} frames, found {}: {}{}", header.frames, found.size(),
                                 missing_text(header, found), absent_text(header)));
}

// `seen` tells which shards have a manifest; not all have one.
tl::unexpected<Error> fail_shards(const fs::path& folder, const ManifestHeader& header, const std::vector<bool>& seen) {
  std::vector<std::int64_t> missing;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!seen[i]) missing.push_back(static_cast<std::int64_t>(i) + 1);
  }
  const bool is_one = missing.size() == 1;
  const std::string shards = fmt::format("shard{} {} of {}", is_one ? "" : "s",
                                         text_of(runs_of(missing), kShownFrameRuns), header.shard.count);
  const Shard first{static_cast<int>(missing.front()), header.shard.count};
  return bad(folder,
             fmt::format("{} {} missing: there is no {}{}{}", shards, is_one ? "is" : "are", manifest_name(first),
                         is_one ? "" : ", for example", absent_text(header)),
             fmt::format("run {} with the options of the others, then merge again; or copy manifest and outputs from "
                         "the machine that has them",
                         shards));
}

// Checks the last run without shards (or shard 1 of 1), which needs no joining.
Result<MergedShards> check_whole(const fs::path& folder, const JoinedManifest& joined) {
  if (!joined.is_there()) return bad(folder, "this folder has no manifest of a shard");
  const ManifestHeader& header = joined.header();
  MergedShards merged{joined.path(), 1, header.frames, header.absent};
  if (const FrameRecord* const animation = joined.find(animation_key(header.batch))) {
    TRY(check_outputs(*animation));
    return merged;
  }
  std::map<std::int64_t, FrameRecord> found;
  add_joined_records(header, joined, Wanted::all, found);
  if (found.size() != header.frames) return fail_missing(folder, header, found);
  for (const auto& [number, record] : found) {
    TRY(check_outputs(record));
  }
  return merged;
}

}  // namespace

Result<MergedShards> merge_shards(const fs::path& folder) {
  const JoinedManifest joined(folder);
  auto group = TRY(choose_group(folder, joined));
  const bool is_done = group && is_joined(*group, joined);
  if (!group || (is_done && joined.header().batch != group->header().batch)) {
    return check_whole(folder, joined);
  }
  ManifestHeader header = group->header();
  std::vector<bool> seen(static_cast<std::size_t>(header.shard.count));
  std::map<std::int64_t, FrameRecord> found;
  for (auto& [path, content] : group->shards) {
    const auto place = static_cast<std::size_t>(content.header.shard.number - 1);
    if (seen[place])
      return bad(path, fmt::format("expected each shard once, found shard {} twice", content.header.shard.number));
    seen[place] = true;
    if (header.absent.empty()) header.absent = content.header.absent;
    for (FrameRecord& record : content.records) {
      // A later run without shards may have converted the frame again.
      const FrameRecord* const other = joined.find(record.job);
      const bool is_old = other != nullptr && *other != record && !changed_file_message(record).empty();
      if (is_old && changed_file_message(*other).empty()) record = *other;
      TRY(check_outputs(record));
      const std::int64_t frame = record.frame;
      if (!found.emplace(frame, std::move(record)).second) {
        return bad(path, fmt::format("expected each frame once, found frame {} twice", frame));
      }
    }
  }
  if (found.size() < header.frames) add_joined_records(header, joined, Wanted::unchanged, found);
  if (found.size() != header.frames) {
    return std::ranges::find(seen, false) != seen.end() ? fail_shards(folder, header, seen)
                                                        : fail_missing(folder, header, found);
  }
  MergedShards merged{{}, header.shard.count, header.frames, header.absent};
  header.shard = {};
  auto manifest = TRY(Manifest::open(folder, header, true, {}));
  for (const auto& [number, record] : found) {
    const FrameRecord* old = manifest.find(record.job);
    if (old != nullptr && *old == record) continue;
    TRY(manifest.add(record));
  }
  merged.manifest = manifest.path();
  return merged;
}

Result<void> check_replaced_shard(const fs::path& folder, const BatchJob& batch, const Shard& shard,
                                  const std::unordered_set<std::string>& files) {
  if (shard.is_all()) return {};
  const fs::path path = folder / manifest_name(shard);
  auto old = read_manifest(path);
  if (!old || old->header.program != generator() || old->header.batch == hash_of(batch)) return {};
  const JoinedManifest joined(folder);
  std::unordered_set<std::string> jobs;
  for (const FrameJob& frame : batch.frames) jobs.insert(convert::hash_of(frame.job));
  const auto is_replaced = [&](const FileRecord& output) {
    std::error_code none;
    return files.contains(fs::path(output.path).lexically_normal().string()) || !fs::exists(output.path, none);
  };
  const auto lost = std::ranges::count_if(old->records, [&](const FrameRecord& record) {
    return !jobs.contains(record.job) && joined.find(record.job) == nullptr &&
           !std::ranges::all_of(record.outputs, is_replaced);
  });
  if (lost == 0) return {};
  return fail(
      ErrorCode::output,
      fmt::format("{}: this run would replace the manifest, which has {} of another, unmerged batch", path.string(),
                  counted(lost, "frame")),
      fmt::format("merge that batch first: isoextract merge {}; or give that batch up and remove its manifests, or "
                  "choose another folder",
                  folder.empty() ? "." : folder.string()));
}

}  // namespace isoextract::batch
