#include "cli/threads.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "base/allocation_error.hpp"
#include "base/counted.hpp"
#include "base/machine.hpp"

namespace isoextract::cli {
Result<void> limit_threads(const std::optional<int>& threads) {
  if (threads) {
    // Never released: oneTBB would start the missing threads at the end of the work.
    [[maybe_unused]] static const auto* const kept =
        new tbb::global_control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(*threads));
  }
  const int all = tbb::this_task_arena::max_concurrency();
  const int wanted = std::min(threads.value_or(all), all);
  const StartableThreads others = start_threads_together(wanted - 1);  // threads like those of oneTBB
  if (others.refusal.empty()) return {};
  const int could = others.count + 1;
  return fail(ErrorCode::unavailable,
              fmt::format("cannot start {}, only {}: {}", counted(wanted, "thread"), could, others.refusal),
              fmt::format("give --threads {}, or raise the limit (ulimit {})", could,
                          address_space_limit() ? "-v, because each thread's stack takes address space" : "-u"));
}

}  // namespace isoextract::cli
