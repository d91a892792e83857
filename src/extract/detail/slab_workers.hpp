// Processes the slabs of a volume, its layers of bricks along z, on several threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/first_error.hpp"
#include "base/parallel.hpp"

namespace isoextract::extract {

// Calls work(slab, worker) for the slabs 0 to slabs - 1, in parallel. make() returns the buffers of one thread, in a
// Result; the thread processes one slab after another in them. Uses at most `most_threads` threads, and fewer if a
// make() after the first fails or throws std::bad_alloc. A single thread processes the slabs in order. Fails as the
// first make() does, as `work` does, or with ErrorCode::cancelled.
template <class Make, class Work>
[[nodiscard]] Result<void> run_slabs(int slabs, int most_threads, const char* stage, const Context& context,
                                     const Make& make, const Work& work) {
  auto first = make();
  if (!first) return tl::unexpected(std::move(first.error()));
  std::vector<std::remove_reference_t<decltype(*first)>> workers;
  workers.push_back(std::move(*first));
  for (const int most = std::min(most_threads, slabs); static_cast<int>(workers.size()) < most;) {
    try {
      auto another = make();
      if (!another) break;
      workers.push_back(std::move(*another));
    } catch (const std::bad_alloc&) {
      break;
    }
  }
  context.progress().begin(stage, static_cast<std::uint64_t>(slabs));
  FirstError failure;
  std::atomic<int> next{0};
  for_each_index(workers.size(), [&](std::size_t number) {
    for (int slab = next++; slab < slabs && !failure.any(); slab = next++) {
      auto done = work(slab, workers[number]);
      if (done) done = context.check();
      if (!done) failure.keep(std::move(done.error()));
      context.progress().advance(1);
    }
  });
  if (failure.error()) return tl::unexpected(std::move(*failure.error()));
  return {};
}

}  // namespace isoextract::extract
