#include "batch/merge_shards.hpp"

#include <algorithm>
#include <system_error>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "batch/frame_range.hpp"
#include "batch/manifest.hpp"

namespace isoextract::batch {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> bad(const fs::path& path, const std::string& what, Hint hint = {}) {
  return fail(ErrorKind::input, fmt::format("{}: {}", path.string(), what), std::move(hint));
}

struct ShardManifest {
  fs::path path;
  ManifestContent content;
};

// The manifests of one batch in one number of shards.
struct ShardGroup {
  std::vector<ShardManifest> shards;                       // by path; at least one
  fs::file_time_type written = fs::file_time_type::min();  // the last time that one of them was

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

Result<std::vector<fs::path>> shard_paths(const fs::path& folder) {
  auto paths = manifest_paths(folder);
  if (!paths) return paths;
  std::erase_if(*paths, [](const fs::path& path) { return path.filename() == manifest_name({}); });
  if (paths->empty()) return bad(folder, "there is no manifest of a shard in this folder");
  return paths;
}

Result<std::vector<ShardGroup>> read_groups(const fs::path& folder) {
  const auto paths = shard_paths(folder);
  if (!paths) return tl::unexpected(paths.error());
  std::vector<ShardGroup> groups;
  for (const fs::path& path : *paths) {
    auto content = read_manifest(path);
    if (!content) return tl::unexpected(std::move(content.error()));
    const Shard& shard = content->header.shard;
    if (shard.number < 1 || shard.number > shard.count) return bad(path, "its shard is none");
    auto group = std::ranges::find_if(groups, [&](const ShardGroup& known) {
      return known.is_of_batch(content->header) && known.header().shard.count == shard.count;
    });
    if (group == groups.end()) group = groups.insert(group, ShardGroup());
    std::error_code none;
    group->written = std::max(group->written, fs::last_write_time(path, none));
    group->shards.push_back({path, std::move(*content)});
  }
  return groups;
}

// Of each batch the group with all frames, or else the newest.
std::vector<ShardGroup> one_of_each_batch(std::vector<ShardGroup> groups) {
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

// Whether the joined manifest has all of the group's records.
bool is_joined(const ShardGroup& group, const std::unordered_map<std::string, FrameRecord>& joined) {
  return group.is_complete() && std::ranges::all_of(group.shards, [&](const ShardManifest& shard) {
           return std::ranges::all_of(shard.content.records, [&](const FrameRecord& record) {
             const auto known = joined.find(record.job);
             return known != joined.end() && known->second == record;
           });
         });
}

std::unordered_map<std::string, FrameRecord> joined_records(const fs::path& folder) {
  std::unordered_map<std::string, FrameRecord> records;
  auto content = read_manifest(folder / manifest_name({}));
  if (!content) return records;  // none yet; one that is damaged fails where it is opened
  for (FrameRecord& record : content->records) {
    std::string job = record.job;
    records.emplace(std::move(job), std::move(record));
  }
  return records;
}

// The group to join: of the batch that is not joined yet. Where all are, the newest, whose files are checked again.
Result<ShardGroup> choose_group(const fs::path& folder) {
  auto read = read_groups(folder);
  if (!read) return tl::unexpected(std::move(read.error()));
  std::vector<ShardGroup> groups = one_of_each_batch(std::move(*read));
  std::ranges::stable_sort(groups, std::ranges::greater(), &ShardGroup::written);
  if (groups.size() == 1) return std::move(groups.front());
  const auto joined = joined_records(folder);
  std::vector<ShardGroup*> open;
  for (ShardGroup& group : groups) {
    if (!is_joined(group, joined)) open.push_back(&group);
  }
  if (open.empty()) return std::move(groups.front());
  if (open.size() == 1) return std::move(*open.front());
  return bad(open.front()->shards.front().path,
             fmt::format("it is of another batch than {}: other frames or options, or another version",
                         open.back()->shards.front().path.string()),
             fmt::format("one batch is joined at a time: remove the manifests of the batch that is given up, for "
                         "example of the older one: {}",
                         fmt::join(open.back()->paths(), " ")));
}

// "3 are missing: 2, 5, 8"
std::string missing_text(const ManifestHeader& header, const std::unordered_set<std::int64_t>& found) {
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

}  // namespace

Result<MergedShards> merge_shards(const fs::path& folder) {
  auto group = choose_group(folder);
  if (!group) return tl::unexpected(std::move(group.error()));
  ManifestHeader header = group->header();
  MergedShards merged{{}, header.shard.count, header.frames, {}};
  std::vector<FrameRecord> records;
  std::vector<bool> seen(static_cast<std::size_t>(header.shard.count));
  std::unordered_set<std::string> jobs;
  std::unordered_set<std::int64_t> found;
  for (auto& [path, content] : group->shards) {
    const auto place = static_cast<std::size_t>(content.header.shard.number - 1);
    if (seen[place]) return bad(path, fmt::format("shard {} is there twice", content.header.shard.number));
    seen[place] = true;
    if (merged.absent.empty()) merged.absent = content.header.absent;
    for (FrameRecord& record : content.records) {
      if (!jobs.insert(record.job).second) return bad(path, fmt::format("frame {} is there twice", record.frame));
      for (const FileRecord& output : record.outputs) {
        const auto now = files::state_of_file(output.path);
        if (!now) return tl::unexpected(now.error());
        if (now->hash != output.state.hash) return bad(output.path, "it is not what its shard has written");
      }
      found.insert(record.frame);
      records.push_back(std::move(record));
    }
  }
  const std::string absent =
      merged.absent.empty() ? "" : fmt::format("; frames that were asked for and have no input: {}", merged.absent);
  for (std::size_t place = 0; place < seen.size(); ++place) {
    if (!seen[place]) return bad(folder, fmt::format("shard {} of {} is missing{}", place + 1, seen.size(), absent));
  }
  if (records.size() != header.frames) {
    return bad(folder, fmt::format("expected {} frames, found {}: {}{}", header.frames, records.size(),
                                   missing_text(header, found), absent));
  }
  std::ranges::stable_sort(records, {}, &FrameRecord::frame);
  header.shard = {};
  auto manifest = Manifest::open(folder, header, true, {});
  if (!manifest) return tl::unexpected(manifest.error());
  for (const FrameRecord& record : records) {
    const FrameRecord* old = manifest->find(record.job);
    if (old != nullptr && *old == record) continue;
    if (auto added = manifest->add(record); !added) return tl::unexpected(added.error());
  }
  merged.manifest = manifest->path();
  return merged;
}

}  // namespace isoextract::batch
