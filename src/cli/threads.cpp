#include "cli/threads.hpp"

#include <algorithm>
#include <exception>
#include <latch>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

namespace isoextract::cli {
namespace {

// Beside this one; all of them at a time, as oneTBB has them.
Result<void> try_threads(int others) {
  std::latch enough(1);
  std::vector<std::jthread> threads;
  std::string refusal;
  try {
    for (int i = 0; i < others; ++i) threads.emplace_back([&] { enough.wait(); });
  } catch (const std::exception& error) {
    refusal = error.what();
  }
  const std::size_t could = threads.size() + 1;
  enough.count_down();
  threads.clear();
  if (refusal.empty()) return {};
  return fail(ErrorKind::unavailable,
              fmt::format("cannot start {} threads, no more than {}: {}", others + 1, could, refusal),
              fmt::format("use no more with --threads {}, or raise the limit (ulimit -u)", could));
}

}  // namespace

Result<void> limit_threads(const std::optional<int>& threads) {
  if (threads) {
    // Never taken back: what it held off would start when the work is done.
    [[maybe_unused]] static const auto* const kept =
        new tbb::global_control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(*threads));
  }
  const int all = tbb::this_task_arena::max_concurrency();
  return try_threads(std::min(threads.value_or(all), all) - 1);
}

}  // namespace isoextract::cli
