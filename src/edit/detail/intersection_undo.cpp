#include "edit/detail/intersection_undo.hpp"

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "mesh/self_intersections.hpp"

namespace isoextract::edit {
namespace {

using ChangedTriangle = std::pair<std::uint32_t, std::uint32_t>;  // the last collapse of a triangle, the triangle

struct PresentMesh {
  mesh::Mesh mesh;
  std::vector<std::uint32_t> numbers;  // of its triangles in the state
};

Result<PresentMesh> present_mesh(const CollapseState& state, const std::string& name, const Context& context) {
  PresentMesh present;
  for (std::uint32_t t = 0; t < state.corners.size(); ++t) {
    if (state.gone[t] == 0) present.numbers.push_back(t);
  }
  present.mesh.name = name;
  present.mesh.memory = TRY(
      context.reserve(state.stored.size_bytes() + present.numbers.size() * (sizeof(glm::uvec3) + sizeof(std::uint32_t)),
                      name + ": the simplified mesh"));
  present.mesh.positions = Buffer<glm::vec3>(state.stored.size());
  std::ranges::copy(state.stored, present.mesh.positions.begin());
  present.mesh.triangles = Buffer<glm::uvec3>(present.numbers.size());
  std::ranges::transform(present.numbers, present.mesh.triangles.begin(),
                         [&](std::uint32_t t) { return state.corners[t]; });
  return present;
}

// Returns for each new pair the triangle that changed last, the latest collapse first.
Result<std::vector<ChangedTriangle>> changed_triangles(const CollapseState& state, const std::string& name,
                                                       const Context& context) {
  constexpr std::uint64_t kMostPairs = 1 << 20;  // at a time
  const auto present = TRY(present_mesh(state, name, context));
  const auto found = TRY(mesh::find_self_intersections(present.mesh, {kMostPairs, kMostPairs}, context));
  std::vector<ChangedTriangle> changed;
  for (const auto& [i, j] : found.examples) {
    const std::uint32_t a = present.numbers[i];
    const std::uint32_t b = present.numbers[j];
    if (state.tangled[a] != 0 && state.tangled[b] != 0) continue;
    for (const std::uint32_t t : {a, b}) {
      const std::uint32_t other = state.changed_by[t == a ? b : a];
      const std::uint32_t own = state.changed_by[t];
      if (own != kNone && (other == kNone || own >= other)) changed.emplace_back(own, t);
    }
  }
  std::ranges::sort(changed, std::greater());
  return changed;
}

}  // namespace

Result<std::uint64_t> undo_intersections(CollapseState& state, std::span<const CollapseLog> logs,
                                         const std::string& name, const Context& context) {
  std::uint64_t undone = 0;
  for (;;) {
    const auto wrong = TRY(changed_triangles(state, name, context));
    if (wrong.empty()) return undone;
    std::vector<RestoredTriangle> changed;
    for (const auto& [collapse, t] : wrong) {
      // An earlier undo may have included this one.
      if (state.changed_by[t] == collapse) undone += undo_collapse(collapse, state, logs, changed);
    }
  }
}

}  // namespace isoextract::edit
