#include "edit/detail/collapse_state.hpp"

#include <algorithm>
#include <iterator>

#include "base/parallel.hpp"

namespace isoextract::edit {

CollapseState::CollapseState(std::span<const glm::vec3> places, std::span<const glm::vec3> stored_places,
                             std::span<const glm::uvec3> triangles, const Sheets& sheets_of_triangles,
                             const CollapseStart* from)
    : positions(places),
      stored(stored_places),
      original(triangles),
      gone(triangles.size(), 0),
      changed_by(triangles.size(), kNone),
      first_sample(triangles.size(), kNone),
      next_sample(places.size(), kNone),
      first_patch(triangles.size(), kNone),
      tangled(triangles.size(), 0),
      known(triangles.size()),
      sheets(sheets_of_triangles),
      start(from != nullptr ? from->corners : triangles),
      original_trees(places, triangles, from != nullptr ? from->not_original : gone, sheets_of_triangles),
      original_slot(original_trees.slots(triangles.size())),
      original_cover(original_trees, original_slot, triangles, places.size(),
                     from != nullptr ? from->not_original : gone, sheets_of_triangles) {
  corners.assign(start.begin(), start.end());
  if (from == nullptr) return;
  gone.assign(from->gone.begin(), from->gone.end());
  gone_at_start = from->gone;
  not_original = from->not_original;
  sides = from->sides;
  attach_removed_vertices();
}

// Makes the vertices that the past has removed samples of their nearest triangles, as PatchCollapse::keep_samples()
// does.
void CollapseState::attach_removed_vertices() {
  std::vector<char> removed(positions.size(), 0);
  for (std::uint32_t t = 0; t < original.size(); ++t) {
    const glm::uvec3& c = original[t];
    if (has_original(t)) removed[c.x] = removed[c.y] = removed[c.z] = 1;
  }
  for (std::uint32_t t = 0; t < corners.size(); ++t) {
    const glm::uvec3& c = corners[t];
    if (gone[t] == 0) removed[c.x] = removed[c.y] = removed[c.z] = 0;
  }
  struct Sample {
    std::uint32_t triangle;
    double distance_squared;
    std::uint32_t vertex;
  };
  std::vector<Sample> samples;
  for (std::uint32_t v = 0; v < removed.size(); ++v) {
    if (removed[v] != 0) samples.push_back({kNone, 0, v});
  }
  if (samples.empty()) return;
  const SheetTrees trees(positions, corners, gone, sheets);
  for_each_fixed_range(samples.size(), 1 << 10, [&](std::size_t begin, std::size_t end) {
    std::uint32_t hint = 0;  // neighbors in the list are often near
    for (std::size_t i = begin; i != end; ++i) {
      const auto nearest = trees.tree(0).nearest(glm::dvec3(positions[samples[i].vertex]), hint);
      hint = nearest.slot;
      samples[i].triangle = trees.triangle(0, nearest.slot);
      samples[i].distance_squared = nearest.distance_squared;
    }
  });
  std::ranges::sort(samples, [](const Sample& a, const Sample& b) {
    if (a.triangle != b.triangle) return a.triangle < b.triangle;
    return a.distance_squared != b.distance_squared ? a.distance_squared > b.distance_squared : a.vertex < b.vertex;
  });
  std::size_t of_triangle = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& sample = samples[i];
    of_triangle = i > 0 && samples[i - 1].triangle == sample.triangle ? of_triangle + 1 : 0;
    if (of_triangle >= kMostSamples) continue;
    next_sample[sample.vertex] = first_sample[sample.triangle];
    first_sample[sample.triangle] = sample.vertex;
  }
}

std::size_t CollapseState::count_remaining() const { return static_cast<std::size_t>(std::ranges::count(gone, 0)); }

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
