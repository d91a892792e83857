#include "edit/detail/orient_triangles.hpp"

#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "mesh/adjacency.hpp"
#include "mesh/component_facts.hpp"
#include "mesh/components.hpp"
#include "mesh/shells.hpp"

namespace isoextract::edit {
namespace {

constexpr std::uint32_t kNoTriangle = std::numeric_limits<std::uint32_t>::max();

struct Neighbor {
  std::uint32_t triangle = kNoTriangle;
  bool agrees = false;  // runs along the edge the other way
};

std::vector<std::array<Neighbor, 3>> neighbors_of(std::size_t triangles, const EdgeUses& uses) {
  std::vector<std::array<Neighbor, 3>> neighbors(triangles);
  uses.for_each_edge([&](std::span<const EdgeUse> edge) {
    if (edge.size() != 2) return;
    const bool agrees = edge[0].rising != edge[1].rising;
    neighbors[edge[0].triangle][edge[0].side] = {edge[1].triangle, agrees};
    neighbors[edge[1].triangle][edge[1].side] = {edge[0].triangle, agrees};
  });
  return neighbors;
}

}  // namespace

OrientFigures orient_patches(mesh::Mesh& mesh, const EdgeUses& uses) {
  const std::size_t count = mesh.triangles.size();
  const auto neighbors = neighbors_of(count, uses);
  enum class Way : std::uint8_t { unknown, kept, turned };
  std::vector<Way> ways(count);
  std::vector<std::uint32_t> patch;
  OrientFigures figures;
  std::uint64_t broken = 0;  // counted from both sides of each edge
  for (std::uint32_t seed = 0; seed < count; ++seed) {
    if (ways[seed] != Way::unknown) continue;
    patch.assign(1, seed);
    ways[seed] = Way::kept;
    std::size_t turned = 0;
    for (std::size_t at = 0; at < patch.size(); ++at) {
      const std::uint32_t t = patch[at];
      turned += ways[t] == Way::turned ? 1 : 0;
      for (const Neighbor& neighbor : neighbors[t]) {
        if (neighbor.triangle == kNoTriangle) continue;
        const Way wanted = (ways[t] == Way::kept) == neighbor.agrees ? Way::kept : Way::turned;
        Way& way = ways[neighbor.triangle];
        if (way == Way::unknown) {
          way = wanted;
          patch.push_back(neighbor.triangle);
        } else if (way != wanted) {
          ++broken;
        }
      }
    }
    const Way minority = 2 * turned > patch.size() ? Way::kept : Way::turned;
    for (const std::uint32_t t : patch) {
      if (ways[t] != minority) continue;
      std::swap(mesh.triangles[t].y, mesh.triangles[t].z);
      ++figures.turned;
    }
  }
  figures.contradictions = broken / 2;
  return figures;
}

Result<std::uint64_t> face_by_nesting(mesh::Mesh& mesh, const Context& context) {
  const auto memory =
      TRY(context.reserve(mesh::Components::bytes(mesh.positions.size()), mesh.name + ": its components"));
  const mesh::Components components(mesh.triangles.span(), mesh.positions.size());
  const auto facts = TRY(mesh::measure_components(mesh, components, glm::dmat3(1.0), context));
  mesh::ShellQuery question;
  for (const mesh::ComponentFacts& component : facts) {
    question.facing.push_back(!component.is_closed() ? mesh::Facing::open
                              : component.volume < 0 ? mesh::Facing::inward
                                                     : mesh::Facing::outward);
  }
  const auto surroundings = TRY(mesh::find_enclosing_shells(mesh, components, question, context));
  std::vector<bool> turns(facts.size());
  std::uint64_t turned = 0;
  for (std::size_t c = 0; c < facts.size(); ++c) {
    if (question.facing[c] == mesh::Facing::open) continue;
    const auto wanted = surroundings[c].in_material() ? mesh::Facing::inward : mesh::Facing::outward;
    turns[c] = question.facing[c] != wanted;
    turned += turns[c] ? 1 : 0;
  }
  if (turned == 0) return turned;
  for (glm::uvec3& t : mesh.triangles) {
    const std::uint32_t component = components.of_vertex(t.x);
    if (component != mesh::Components::kNone && turns[component]) std::swap(t.y, t.z);
  }
  return turned;
}

}  // namespace isoextract::edit
