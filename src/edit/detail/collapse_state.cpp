#include "edit/detail/collapse_state.hpp"

#include <algorithm>
#include <iterator>

namespace isoextract::edit {

CollapseState::CollapseState(std::span<const glm::vec3> places, std::span<const glm::vec3> stored_places,
                             std::span<const glm::uvec3> triangles, const Sheets& sheets_of_triangles)
    : positions(places),
      stored(stored_places),
      original(triangles),
      corners(triangles.begin(), triangles.end()),
      gone(triangles.size(), 0),
      changed_by(triangles.size(), kNone),
      first_sample(triangles.size(), kNone),
      next_sample(places.size(), kNone),
      tangled(triangles.size(), 0),
      known(triangles.size()),
      sheets(sheets_of_triangles),
      original_trees(places, triangles, gone, sheets_of_triangles),
      original_slot(original_trees.slots(triangles.size())) {}

const CollapseLog& find_log(std::uint32_t collapse, std::span<const CollapseLog> logs) {
  return *std::prev(std::upper_bound(logs.begin(), logs.end(), collapse,
                                     [](std::uint32_t n, const CollapseLog& log) { return n < log.first; }));
}

const Collapse& find_collapse(std::uint32_t collapse, std::span<const CollapseLog> logs) {
  const CollapseLog& log = find_log(collapse, logs);
  return log.collapses[collapse - log.first];
}

void drop_restored_samples(CollapseState& state) {
  std::vector<char> there(state.positions.size(), 0);
  for (std::size_t t = 0; t < state.corners.size(); ++t) {
    const glm::uvec3& c = state.corners[t];
    if (state.gone[t] == 0) there[c.x] = there[c.y] = there[c.z] = 1;
  }
  for (std::uint32_t& first : state.first_sample) {
    std::uint32_t* link = &first;
    while (*link != kNone) {
      if (there[*link] != 0) {
        *link = state.next_sample[*link];
      } else {
        link = &state.next_sample[*link];
      }
    }
  }
}

std::size_t undo_collapse(std::uint32_t collapse, CollapseState& state, std::span<const CollapseLog> logs,
                          std::vector<RestoredTriangle>& changed) {
  std::size_t count = 0;
  std::vector<std::uint32_t> waiting{collapse};
  while (!waiting.empty()) {
    const std::uint32_t number = waiting.back();
    const CollapseLog& log = find_log(number, logs);
    const Collapse& done = log.collapses[number - log.first];
    const std::span records(log.records.data() + done.first_record, done.records);
    const auto later = std::find_if(records.begin(), records.end(), [&](const CollapseLog::Record& record) {
      return state.changed_by[record.triangle] != number;
    });
    if (later != records.end()) {
      waiting.push_back(state.changed_by[later->triangle]);
      continue;
    }
    for (const CollapseLog::Record& record : records) {
      changed.push_back({record.triangle, state.corners[record.triangle]});
      if (state.gone[record.triangle] != 0) {
        state.gone[record.triangle] = 0;
      } else {
        glm::uvec3& t = state.corners[record.triangle];
        for (int corner = 0; corner < 3; ++corner) {
          if (t[corner] == done.to) t[corner] = done.vertex;
        }
      }
      state.changed_by[record.triangle] = record.changed_before;
      state.known[record.triangle] = {};
    }
    ++count;
    waiting.pop_back();
  }
  return count;
}

}  // namespace isoextract::edit
