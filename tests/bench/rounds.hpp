// Alternating runs: what disturbs the machine for a while disturbs all contestants alike.
#pragma once

#include <string>
#include <vector>

#include "bench/contestant.hpp"

namespace isoextract::bench {

struct Entrant {
  std::unique_ptr<Contestant> contestant;
  int threads = 1;
  std::size_t compared_with = 0;  // the number of an entrant of isoextract
  Outcome first;                  // of the run with which it entered: threads start and the system clears fresh pages
};

// Runs it once, before any rounds.
[[nodiscard]] Entrant enter(std::unique_ptr<Contestant> contestant, int threads, std::size_t compared_with);

struct Row {
  std::string name;
  std::string program;
  int threads = 1;
  double first_milliseconds = 0;     // before the rounds
  std::vector<double> milliseconds;  // one a round
  double isoextract_to_this = 1;     // the time of the row that it is compared with by its own: median over the rounds
  Outcome outcome;                   // of the last run
};

// The rows of one input in one type.
struct Group {
  std::string input;
  int size = 0;  // 0 for files
  glm::i64vec3 dims{0};
  std::string type;
  bool smooth_normals = false;
  std::uint64_t samples = 0;  // of sparse fields those of their blocks
  std::vector<Row> rows;
};

// `rounds` times each of them in turn.
[[nodiscard]] std::vector<Row> run_rounds(const std::vector<Entrant>& entrants, int rounds);

// Returns the sum of two rows of the same rounds, as if one ran after the other.
[[nodiscard]] Row sum_of(const Row& a, const Row& b, std::string name, const Row& compared_with);

}  // namespace isoextract::bench
