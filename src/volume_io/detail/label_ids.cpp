#include "volume_io/detail/label_ids.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <limits>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "volume_io/detail/sample_store.hpp"

namespace isoextract::volume_io {
namespace {

constexpr std::size_t kSamplesATask = std::size_t{1} << 20;

std::int64_t id_at(std::span<const std::byte> stored, std::size_t sample) {
  std::int64_t id = 0;
  std::memcpy(&id, stored.data() + sample * sizeof id, sizeof id);
  return id;
}

// Calls run(begin, end, id) for the runs of equal ids among the samples of a task.
template <class Run>
void for_each_run(std::span<const std::byte> stored, std::size_t task, const Run& run) {
  const std::size_t end = std::min((task + 1) * kSamplesATask, stored.size() / sizeof(std::int64_t));
  for (std::size_t begin = task * kSamplesATask; begin < end;) {
    const std::int64_t id = id_at(stored, begin);
    std::size_t next = begin + 1;
    while (next < end && id_at(stored, next) == id) ++next;
    run(begin, next, id);
    begin = next;
  }
}

void make_unique(std::vector<std::int64_t>& ids) {
  std::ranges::sort(ids);
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

// Collects the ids of a task, sorted and each once.
void collect_ids(std::span<const std::byte> stored, std::size_t task, std::vector<std::int64_t>& ids) {
  constexpr std::size_t kLeast = 4096;
  std::size_t limit = kLeast;
  for_each_run(stored, task, [&](std::size_t /*begin*/, std::size_t /*end*/, std::int64_t id) {
    if (!ids.empty() && ids.back() == id) return;
    if (ids.size() == limit) {
      make_unique(ids);
      limit = std::max(kLeast, 2 * ids.size());
    }
    ids.push_back(id);
  });
  make_unique(ids);
}

// Returns an error that tells where the first id beyond the greatest std::int64_t is.
tl::unexpected<Error> too_large(std::span<const std::byte> stored, const glm::ivec3& dims, const std::string& name) {
  std::size_t at = 0;
  while (id_at(stored, at) >= 0) ++at;
  const auto nx = static_cast<std::size_t>(dims.x);
  const auto ny = static_cast<std::size_t>(dims.y);
  return fail(ErrorCode::input,
              fmt::format("{}: expected ids of labels up to {}, found {} at sample ({}, {}, {})", name,
                          std::numeric_limits<std::int64_t>::max(), static_cast<std::uint64_t>(id_at(stored, at)),
                          at % nx, at / nx % ny, at / nx / ny),
              "renumber the ids of the label map");
}

}  // namespace

Result<IndexedIds> index_ids(const field::DenseSamples& wide, Integer64 type, const std::string& name,
                             const Context& context, Notes& notes) {
  const std::size_t count = wide.count();
  const std::span stored(static_cast<const std::byte*>(wide.data), count * sizeof(std::int64_t));
  const auto leave = [&](std::size_t task) {
    wide.leave(task * kSamplesATask, std::min((task + 1) * kSamplesATask, count));
  };
  const std::size_t tasks = (count + kSamplesATask - 1) / kSamplesATask;
  auto store = TRY(SampleStore::make(name, wide.dims, field::SampleType::u32, context, "indices of labels, "));
  auto* const indices = reinterpret_cast<std::uint32_t*>(store.bytes().data());
  context.progress().begin("finding labels", 2 * tasks);
  std::vector<std::vector<std::int64_t>> of_task(tasks);
  for_each_index(tasks, [&](std::size_t task) {
    if (context.cancelled()) return;
    collect_ids(stored, task, of_task[task]);
    leave(task);
    context.progress().advance(1);
  });
  TRY(context.check());
  std::vector<std::int64_t> found;
  for (const std::vector<std::int64_t>& some : of_task) found.insert(found.end(), some.begin(), some.end());
  of_task.clear();
  make_unique(found);
  if (type == Integer64::u64 && !found.empty() && found.front() < 0) return too_large(stored, wide.dims, name);
  std::vector<std::int64_t> ids{0};
  ids.reserve(found.size() + 1);
  std::ranges::copy_if(found, std::back_inserter(ids), [](std::int64_t id) { return id != 0; });
  std::unordered_map<std::int64_t, std::uint32_t> index_of;
  index_of.reserve(ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) index_of.emplace(ids[i], static_cast<std::uint32_t>(i));
  for_each_index(tasks, [&](std::size_t task) {
    if (context.cancelled()) return;
    for_each_run(stored, task, [&](std::size_t begin, std::size_t end, std::int64_t id) {
      const std::uint32_t index = index_of.at(id);
      for (std::size_t sample = begin; sample < end; ++sample) indices[sample] = index;
    });
    leave(task);
    const std::size_t first = task * kSamplesATask;
    store.leave(std::as_bytes(std::span(indices + first, std::min(kSamplesATask, count - first))));
    context.progress().advance(1);
  });
  TRY(context.check());
  if (wide.lost()) {
    return fail(ErrorCode::input, name + ": the file became shorter, or reading it failed, during the run");
  }
  return IndexedIds{std::move(store).finish(notes), std::make_shared<const std::vector<std::int64_t>>(std::move(ids))};
}

}  // namespace isoextract::volume_io
