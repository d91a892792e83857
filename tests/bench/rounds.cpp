#include "bench/rounds.hpp"

#include <tbb/global_control.h>

#include "base/median.hpp"
#include "bench/vtk_threads.hpp"

namespace isoextract::bench {
namespace {

Outcome run_with_threads(Contestant& contestant, int threads) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  set_vtk_threads(threads);
  return contestant.run();
}

void compare(const Row& isoextract, Row& row) {
  std::vector<double> ratios;
  for (std::size_t round = 0; round < row.milliseconds.size(); ++round) {
    ratios.push_back(isoextract.milliseconds[round] / row.milliseconds[round]);
  }
  row.isoextract_to_this = median(std::move(ratios));
}

}  // namespace

Entrant enter(std::unique_ptr<Contestant> contestant, int threads, std::size_t compared_with) {
  const Outcome first = run_with_threads(*contestant, threads);
  return {std::move(contestant), threads, compared_with, first};
}

std::vector<Row> run_rounds(const std::vector<Entrant>& entrants, int rounds) {
  std::vector<Row> rows;
  for (const Entrant& entrant : entrants) {
    rows.push_back({entrant.contestant->name(),
                    entrant.contestant->program(),
                    entrant.threads,
                    entrant.first.milliseconds,
                    {},
                    1,
                    {}});
  }
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < entrants.size(); ++i) {
      rows[i].outcome = run_with_threads(*entrants[i].contestant, entrants[i].threads);
      rows[i].milliseconds.push_back(rows[i].outcome.milliseconds);
    }
  }
  for (std::size_t i = 0; i < entrants.size(); ++i) compare(rows[entrants[i].compared_with], rows[i]);
  return rows;
}

Row sum_of(const Row& a, const Row& b, std::string name, const Row& compared_with) {
  Row sum{std::move(name), a.program, a.threads, a.first_milliseconds + b.first_milliseconds,
          a.milliseconds,  1,         a.outcome};
  for (std::size_t round = 0; round < b.milliseconds.size(); ++round) sum.milliseconds[round] += b.milliseconds[round];
  sum.outcome.bytes_read += b.outcome.bytes_read;
  sum.outcome.bytes_written += b.outcome.bytes_written;
  compare(compared_with, sum);
  return sum;
}

}  // namespace isoextract::bench
