#include "batch/shard.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <system_error>

#include <fmt/format.h>

namespace isoextract::batch {
namespace {

std::optional<int> whole(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

// The environment variables of one job scheduler.
struct Scheme {
  const char* number;
  const char* count;
  const char* first;  // smallest number; nullptr: 0
  const char* step;
  const char* hint;  // if the count is missing
};
constexpr std::array kSchemes{
    Scheme{"SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_MIN", "SLURM_ARRAY_TASK_STEP",
           "Slurm sets the count in the tasks of an array; or give the shard as K/N"},
    Scheme{
        "JOB_COMPLETION_INDEX", "JOB_COMPLETIONS", nullptr, nullptr,
        "Kubernetes does not set JOB_COMPLETIONS: give it the number that the job has as spec.completions, in env of "
        "the container (name: JOB_COMPLETIONS, value: \"8\"); or give the shard as K/N"},
};

// Returns the variable's number, or nullopt if it is not set.
Result<std::optional<int>> variable(const std::function<const char*(const char*)>& get, const char* name) {
  const char* const text = get(name);
  if (text == nullptr || *text == '\0') return std::nullopt;
  const auto number = whole(text);
  if (!number) return fail(ErrorCode::usage, fmt::format("{}: expected a whole number, found '{}'", name, text));
  return number;
}

}  // namespace

Result<ShardChoice> parse_shard(const std::string& text) {
  if (text == "auto") return ShardChoice();
  const std::size_t slash = std::min(text.find('/'), text.size());
  const std::string_view after = std::string_view(text).substr(std::min(slash + 1, text.size()));
  const Shard shard{whole(std::string_view(text).substr(0, slash)).value_or(0), whole(after).value_or(0)};
  if (shard.number < 1 || shard.count < shard.number) {
    return fail(ErrorCode::usage, fmt::format("expected auto or a shard K/N with K from 1 to N, found '{}'", text));
  }
  return ShardChoice{shard};
}

Result<std::optional<Shard>> shard_of_environment(const std::function<const char*(const char*)>& get) {
  for (const Scheme& scheme : kSchemes) {
    std::array<std::optional<int>, 4> found;
    const std::array names{scheme.number, scheme.count, scheme.first, scheme.step};
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] == nullptr) continue;
      found[i] = TRY(variable(get, names[i]));
    }
    const auto [number, count, first, step] = found;
    if (!number) continue;
    if (!count) {
      return fail(
          ErrorCode::usage,
          fmt::format("{} is {}, but {}, the number of shards, is missing", scheme.number, *number, scheme.count),
          scheme.hint);
    }
    const std::int64_t from_first = std::int64_t{*number} - first.value_or(0);
    const std::int64_t index = step.value_or(1) > 0 ? from_first / step.value_or(1) : -1;
    if (from_first < 0 || index < 0 || index >= *count || index * step.value_or(1) != from_first) {
      return fail(ErrorCode::usage,
                  fmt::format("{}: expected one of the {} task numbers from {} on in steps of {}, found {}",
                              scheme.number, *count, first.value_or(0), step.value_or(1), *number),
                  "give the shard as K/N");
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

}  // namespace isoextract::batch
