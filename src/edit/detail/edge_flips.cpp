#include "edit/detail/edge_flips.hpp"

#include <algorithm>
#include <limits>

#include "edit/detail/edge_across.hpp"

namespace isoextract::edit {

EdgeFlips::EdgeFlips(mesh::Mesh& mesh, const Signal& signal)
    : mesh_(mesh),
      signal_(signal),
      around_(mesh.triangles.span(), mesh.positions.size()),
      counter_(mesh),
      changed_(mesh.positions.size(), 0) {}

std::size_t EdgeFlips::run(std::span<const std::array<std::uint32_t, 2>> pairs, const Context& context) {
  std::size_t flips = 0;
  for (const auto& pair : pairs) {
    if (!context.check()) break;
    const auto best = best_of_pair(pair, [&](std::uint32_t t, int corner) { return flip_at(t, corner); });
    if (!best) continue;
    apply(*best);
    ++flips;
  }
  return flips;
}

bool EdgeFlips::are_joined(std::uint32_t a, std::uint32_t b) const {
  return std::ranges::any_of(around_.corners(a), [&](mesh::Corner corner) {
    const glm::uvec3& t = mesh_.triangles[mesh::triangle_of(corner)];
    return t.x == b || t.y == b || t.z == b;
  });
}

// Returns the flip of the edge that starts at this corner; nothing unless it leaves fewer intersecting pairs.
std::optional<EdgeFlips::Flip> EdgeFlips::flip_at(std::uint32_t t, int corner) const {
  const glm::uvec3& own = mesh_.triangles[t];
  const std::uint32_t a = own[corner];
  const std::uint32_t b = own[(corner + 1) % 3];
  const std::uint32_t c = own[(corner + 2) % 3];
  if (changed_[a] != 0 || changed_[b] != 0 || changed_[c] != 0) return std::nullopt;
  const auto other_corner = find_corner_across(mesh_, around_, a, b);
  if (!other_corner) return std::nullopt;
  const auto other = static_cast<std::uint32_t>(mesh::triangle_of(*other_corner));
  const std::uint32_t d = mesh_.triangles[other][static_cast<int>((*other_corner % 3 + 2) % 3)];
  if (d == c || changed_[d] != 0 || are_joined(c, d)) return std::nullopt;
  if (std::ranges::any_of(std::array{a, b, c, d}, [&](std::uint32_t v) { return signal_.constraints(v) >= kFixed; })) {
    return std::nullopt;
  }
  Flip flip{{PairCounter::Triangle{t, {a, d, c}}, PairCounter::Triangle{other, {d, b, c}}}, 0};
  const std::uint8_t sides = signal_.sides_of(own);  // a cap stays a cap
  for (const glm::uvec3& corners : {mesh_.triangles[other], flip.after[0].corners, flip.after[1].corners}) {
    if (signal_.sides_of(corners) != sides) return std::nullopt;
  }
  if (!counter_.has_area(flip.after[0].corners) || !counter_.has_area(flip.after[1].corners)) return std::nullopt;
  const std::array before{PairCounter::Triangle{t, own}, PairCounter::Triangle{other, mesh_.triangles[other]}};
  const std::size_t pairs = counter_.count(before, std::numeric_limits<std::size_t>::max());
  const std::size_t left = counter_.count(flip.after, pairs);
  if (left >= pairs) return std::nullopt;
  flip.gain = pairs - left;
  return flip;
}

void EdgeFlips::apply(const Flip& flip) {
  for (const PairCounter::Triangle& t : flip.after) {
    mesh_.triangles[t.number] = t.corners;
    counter_.update(t.number);
    for (int corner = 0; corner < 3; ++corner) changed_[t.corners[corner]] = 1;
  }
}

}  // namespace isoextract::edit
