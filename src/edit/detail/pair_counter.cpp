#include "edit/detail/pair_counter.hpp"

#include <algorithm>

#include "base/buffer.hpp"
#include "base/parallel.hpp"
#include "mesh/exact_sign.hpp"

namespace isoextract::edit {

PairCounter::PairCounter(const mesh::Mesh& mesh)
    : mesh_(mesh), tree_(tree_of_triangles()), slots_(mesh.triangles.size()) {
  const auto numbers = tree_.numbers();
  for (std::uint32_t slot = 0; slot < numbers.size(); ++slot) slots_[numbers[slot]] = slot;
}

std::uint64_t PairCounter::bytes(const mesh::Mesh& mesh) {
  return mesh::BoxTree::bytes(mesh.triangles.size()) + mesh.triangles.size() * sizeof(std::uint32_t);
}

mesh::BoxTree PairCounter::tree_of_triangles() const {
  Buffer<mesh::BoxTree::Item> items(mesh_.triangles.size());
  for_each_index(items.size(), [&](std::size_t t) {
    items[t] = {box_of(mesh_.triangles[t]).center(), static_cast<std::uint32_t>(t)};
  });
  return {items.span(), [&](std::uint32_t t) { return box_of(mesh_.triangles[t]); }};
}

mesh::FloatBox PairCounter::box_of(const glm::uvec3& corners) const {
  return mesh::box_around(mesh_.positions[corners.x], mesh_.positions[corners.y], mesh_.positions[corners.z]);
}

mesh::PlacedTriangle PairCounter::placed(const glm::uvec3& corners) const {
  return {{glm::dvec3(mesh_.positions[corners.x]), glm::dvec3(mesh_.positions[corners.y]),
           glm::dvec3(mesh_.positions[corners.z])}};
}

bool PairCounter::has_area(const glm::uvec3& corners) const {
  const mesh::PlacedTriangle p = placed(corners);
  return !mesh::are_collinear(p.corners[0], p.corners[1], p.corners[2]);
}

bool PairCounter::meet(const glm::uvec3& a, const glm::uvec3& b) const {
  return box_of(a).meets(box_of(b)) && has_area(a) && has_area(b) && mesh::find_overlap(placed(a), placed(b)).meet;
}

std::size_t PairCounter::count(std::span<const Triangle> triangles, std::size_t most) const {
  std::size_t pairs = 0;
  for (std::size_t i = 0; i < triangles.size() && pairs < most; ++i) {
    const glm::uvec3& corners = triangles[i].corners;
    for (std::size_t j = 0; j < i; ++j) pairs += meet(corners, triangles[j].corners) ? 1 : 0;
    tree_.for_each_near(box_of(corners), [&](std::uint32_t other) {
      if (pairs >= most || std::ranges::find(triangles, other, &Triangle::number) != triangles.end()) return;
      pairs += meet(corners, mesh_.triangles[other]) ? 1 : 0;
    });
  }
  return std::min(pairs, most);
}

bool PairCounter::is_taken(std::uint32_t vertex) const {
  const glm::vec3& here = mesh_.positions[vertex];
  bool taken = false;
  tree_.for_each_near({here, here}, [&](std::uint32_t t) {
    const glm::uvec3& corners = mesh_.triangles[t];
    for (int corner = 0; corner < 3; ++corner) {
      taken = taken || (corners[corner] != vertex && mesh_.positions[corners[corner]] == here);
    }
  });
  return taken;
}

void PairCounter::update(std::uint32_t number) { tree_.enlarge(slots_[number], box_of(mesh_.triangles[number])); }

}  // namespace isoextract::edit
