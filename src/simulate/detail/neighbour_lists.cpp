#include "simulate/detail/neighbour_lists.hpp"

#include <array>
#include <string>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace isoextract::simulate {
namespace {

// Makes room for at least `count` values, a quarter more than that where there is none yet.
template <class T>
Result<void> make_room(Buffer<T>& values, Reservation& memory, std::size_t count, const Context& context) {
  if (values.size() >= count) return {};
  const std::size_t wanted = count + count / 4;
  values = Buffer<T>();
  memory.release();
  auto reserved = context.reserve(std::uint64_t{wanted} * sizeof(T), "neighbours of particles");
  if (!reserved) return tl::unexpected(reserved.error());
  memory = std::move(*reserved);
  values = Buffer<T>(wanted);
  return {};
}

// f(particle, visit) for each particle, in parallel; visit(g) calls g(neighbour) in the order of the spots.
template <class F>
void for_each_particle(const points::CellGrid& grid, std::span<const glm::dvec3> places, double reach, const F& f) {
  const double reach2 = reach * reach;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, grid.cell_count(), 16), [&](const auto& range) {
    for (std::size_t c = range.begin(); c != range.end(); ++c) {
      // Nine columns of cells; each is one run of spots.
      std::array<std::pair<std::size_t, std::size_t>, 9> runs;
      std::size_t run_count = 0;
      const points::CellGrid::Cell& cell = grid.cell(c);
      grid.for_each_run(cell.at - 1, cell.at + 1, [&](std::size_t first, std::size_t last) {
        runs[run_count++] = {grid.cell(first).first, grid.cell_end(last - 1)};
      });
      for (std::size_t i = cell.first; i != grid.cell_end(c); ++i) {
        f(i, [&](const auto& g) {
          const glm::dvec3 place = places[i];
          for (std::size_t r = 0; r < run_count; ++r) {
            for (std::size_t j = runs[r].first; j != runs[r].second; ++j) {
              const glm::dvec3 d = place - places[j];
              if (glm::dot(d, d) < reach2 && j != i) g(static_cast<std::uint32_t>(j));
            }
          }
        });
      }
    }
  });
}

}  // namespace

Result<void> NeighbourLists::make(const points::CellGrid& grid, std::span<const glm::dvec3> places, double reach,
                                  const Context& context) {
  const std::size_t count = places.size();
  if (auto done = make_room(firsts_, firsts_memory_, count + 1, context); !done) return done;
  for_each_particle(grid, places, reach, [&](std::size_t i, const auto& visit) {
    std::size_t near = 0;
    visit([&](std::uint32_t) { ++near; });
    firsts_[i + 1] = near;
  });
  firsts_[0] = 0;
  for (std::size_t i = 0; i < count; ++i) firsts_[i + 1] += firsts_[i];
  if (auto done = make_room(neighbours_, neighbours_memory_, firsts_[count], context); !done) return done;
  for_each_particle(grid, places, reach, [&](std::size_t i, const auto& visit) {
    std::uint32_t* next = neighbours_.data() + firsts_[i];
    visit([&](std::uint32_t j) { *next++ = j; });
  });
  return {};
}

}  // namespace isoextract::simulate
