// Ranks that are threads of the test in place of processes.
#pragma once

#include <barrier>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/ranks.hpp"

namespace isoextract::test {

inline constexpr int kRanks = 3;

struct Meeting {
  std::barrier<> all{kRanks};
  std::vector<std::string> bytes = std::vector<std::string>(kRanks);
};

class ThreadLink final : public RankLink {
 public:
  ThreadLink(Meeting& meeting, int rank) : meeting_(meeting), rank_(rank) {}

  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int size() const override { return kRanks; }
  [[nodiscard]] int node() const override { return 0; }
  Result<std::vector<std::string>> gather(std::string_view bytes) override {
    meeting_.bytes[static_cast<std::size_t>(rank_)] = bytes;
    meeting_.all.arrive_and_wait();
    auto all = meeting_.bytes;
    meeting_.all.arrive_and_wait();
    return all;
  }
  Result<void> send(int /*to*/, std::string_view /*bytes*/) override { return {}; }
  Result<std::optional<RankMessage>> receive(std::chrono::milliseconds /*most*/) override { return std::nullopt; }
  void leave() override { meeting_.all.arrive_and_wait(); }

 private:
  Meeting& meeting_;
  int rank_;
};

// Calls work(ranks) once for each of kRanks ranks, at the same time.
inline void run_ranks(const std::function<void(Ranks&)>& work) {
  Meeting meeting;
  std::vector<std::jthread> threads;
  for (int r = 0; r < kRanks; ++r) {
    threads.emplace_back([&, r] {
      Ranks ranks(std::make_unique<ThreadLink>(meeting, r));
      work(ranks);
    });
  }
}

}  // namespace isoextract::test
