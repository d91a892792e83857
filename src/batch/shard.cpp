#include "batch/shard.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <system_error>
#include <unordered_set>

#include <fmt/format.h>

#include "batch/manifest.hpp"

namespace isoextract::batch {
namespace {

namespace fs = std::filesystem;

std::optional<int> whole(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

// The variables of a job scheduler.
struct Scheme {
  const char* number;
  const char* count;
  const char* first;  // the least number; nullptr: 0
  const char* step;
};
constexpr std::array kSchemes{
    Scheme{"SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_MIN", "SLURM_ARRAY_TASK_STEP"},
    Scheme{"JOB_COMPLETION_INDEX", "JOB_COMPLETIONS", nullptr, nullptr},
};

// A variable's number. None where it is not set.
Result<std::optional<int>> variable(const std::function<const char*(const char*)>& get, const char* name) {
  const char* const text = get(name);
  if (text == nullptr || *text == '\0') return std::nullopt;
  const auto number = whole(text);
  if (!number) return fail(ErrorKind::usage, fmt::format("{}: expected a whole number, found '{}'", name, text));
  return number;
}

}  // namespace

Result<ShardChoice> parse_shard(const std::string& text) {
  if (text == "auto") return ShardChoice();
  const std::size_t slash = std::min(text.find('/'), text.size());
  const std::string_view after = std::string_view(text).substr(std::min(slash + 1, text.size()));
  const Shard shard{whole(std::string_view(text).substr(0, slash)).value_or(0), whole(after).value_or(0)};
  if (shard.number < 1 || shard.count < shard.number) {
    return fail(ErrorKind::usage, fmt::format("expected auto or a shard K/N with K from 1 to N, found '{}'", text));
  }
  return ShardChoice{shard};
}

Result<std::optional<Shard>> shard_of_environment(const std::function<const char*(const char*)>& get) {
  for (const Scheme& scheme : kSchemes) {
    std::array<std::optional<int>, 4> found;
    const std::array names{scheme.number, scheme.count, scheme.first, scheme.step};
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] == nullptr) continue;
      auto value = variable(get, names[i]);
      if (!value) return tl::unexpected(value.error());
      found[i] = *value;
    }
    const auto [number, count, first, step] = found;
    if (!number) continue;
    if (!count) {
      return fail(ErrorKind::usage, fmt::format("{} is {}, and {} does not say how many there are", scheme.number,
                                                *number, scheme.count));
    }
    const std::int64_t from_first = std::int64_t{*number} - first.value_or(0);
    const std::int64_t index = step.value_or(1) > 0 ? from_first / step.value_or(1) : -1;
    if (from_first < 0 || index < 0 || index >= *count || index * step.value_or(1) != from_first) {
      return fail(ErrorKind::usage, fmt::format("{} is {}, which is none of {} (from {} on)", scheme.number, *number,
                                                *count, first.value_or(0)));
    }
    return Shard{static_cast<int>(index) + 1, *count};
  }
  return std::nullopt;
}

std::string scheduler_variable(const std::function<const char*(const char*)>& get) {
  for (const Scheme& scheme : kSchemes) {
    const char* const text = get(scheme.number);
    if (text != nullptr && *text != '\0') return scheme.number;
  }
  return {};
}

std::vector<std::size_t> frames_of(const BatchJob& batch, const Shard& shard) {
  std::vector<std::size_t> frames;
  for (auto i = static_cast<std::size_t>(shard.number - 1); i < batch.frames.size();
       i += static_cast<std::size_t>(shard.count)) {
    frames.push_back(i);
  }
  return frames;
}

Result<MergedShards> merge_shards(const fs::path& folder) {
  const auto bad = [&](const fs::path& path, const std::string& what) {
    return fail(ErrorKind::input, fmt::format("{}: {}", path.string(), what));
  };
  std::vector<fs::path> paths;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (is_manifest_name(name) && name != manifest_name({})) {
      paths.push_back(entry->path());
    }
  }
  if (error) return bad(folder, fmt::format("the folder cannot be read: {}", error.message()));
  if (paths.empty()) return bad(folder, "there is no manifest of a shard in this folder");
  std::ranges::sort(paths);

  std::vector<FrameRecord> records;
  std::optional<ManifestHeader> all;
  std::vector<bool> seen;
  std::unordered_set<std::string> jobs;
  for (const fs::path& path : paths) {
    auto content = read_manifest(path);
    if (!content) return tl::unexpected(content.error());
    const ManifestHeader& header = content->header;
    if (!all) {
      all = header;
      seen.resize(static_cast<std::size_t>(std::max(header.shard.count, 1)));
    }
    if (header.batch != all->batch || header.program != all->program || header.shard.count != all->shard.count) {
      return bad(path, fmt::format("it is of another batch than {}: other frames or options, another number of shards "
                                   "or another version",
                                   paths.front().string()));
    }
    if (header.shard.number < 1 || header.shard.number > header.shard.count) return bad(path, "its shard is none");
    const auto place = static_cast<std::size_t>(header.shard.number - 1);
    if (seen[place]) return bad(path, fmt::format("shard {} is there twice", header.shard.number));
    seen[place] = true;
    for (FrameRecord& record : content->records) {
      if (!jobs.insert(record.job).second) return bad(path, fmt::format("frame {} is there twice", record.frame));
      for (const FileRecord& output : record.outputs) {
        const auto now = files::state_of_file(output.path);
        if (!now) return tl::unexpected(now.error());
        if (now->hash != output.state.hash) return bad(output.path, "it is not what its shard has written");
      }
      records.push_back(std::move(record));
    }
  }
  for (std::size_t place = 0; place < seen.size(); ++place) {
    if (!seen[place]) return bad(folder, fmt::format("shard {} of {} is missing", place + 1, seen.size()));
  }
  if (records.size() != all->frames) {
    return bad(folder, fmt::format("expected {} frames, found {}: {} are missing", all->frames, records.size(),
                                   all->frames - std::min<std::uint64_t>(all->frames, records.size())));
  }
  std::ranges::stable_sort(records, {}, &FrameRecord::frame);
  ManifestHeader header = *all;
  header.shard = {};
  auto manifest = Manifest::open(folder, header, true, {});
  if (!manifest) return tl::unexpected(manifest.error());
  for (const FrameRecord& record : records) {
    const FrameRecord* old = manifest->find(record.job);
    if (old != nullptr && *old == record) continue;
    if (auto added = manifest->add(record); !added) return tl::unexpected(added.error());
  }
  return MergedShards{manifest->path(), all->shard.count, all->frames};
}

}  // namespace isoextract::batch
