// What the preset tsan has to see, and what it must not report; planted_race_test.py runs both.
//
//   planted_race race      two bodies of one tbb::parallel_for, on two threads, write one variable: a race
//   planted_race in_order  the same bodies take only what was written before the loop, and write only what is read
//                          after it: no race, where the sanitizer sees how oneTBB hands work over
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <string_view>
#include <thread>

namespace {

constexpr auto kPatience = std::chrono::seconds(60);
constexpr int kRounds = 3;  // the first one starts the second thread, which would be order enough

struct Meeting {
  std::atomic<int> here{0};

  // Whether both bodies have begun, so on two threads. Relaxed: the meeting must put nothing in order.
  bool wait_for_both() {
    here.fetch_add(1, std::memory_order_relaxed);
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (here.load(std::memory_order_relaxed) < 2) {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::yield();
    }
    return true;
  }
};

// Calls body(0) and body(1) at the same time; false where they did not meet.
template <typename Body>
bool on_two_threads(const Body& body) {
  Meeting meeting;
  std::array<bool, 2> met{};
  tbb::parallel_for(std::size_t{0}, met.size(), [&](std::size_t i) {
    met[i] = meeting.wait_for_both();
    body(i);
  });
  return met[0] && met[1];
}

}  // namespace

int main(int argc, char** argv) {
  const bool race = argc == 2 && argv[1] == std::string_view("race");
  const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
  int written = 0;
  std::array<int, 2> read{};
  bool met = true;
  for (int round = 0; round < kRounds && met; ++round) {
    ++written;
    met = on_two_threads([&](std::size_t i) {
      read[i] += written;
      if (race) ++written;
    });
  }
  std::printf("%s: %d + %d\n", met ? "met" : "did not meet", read[0], read[1]);
  return met ? 0 : 1;
}
