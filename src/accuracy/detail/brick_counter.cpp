#include "accuracy/detail/brick_counter.hpp"

#include <utility>

namespace isoextract::accuracy {

Result<bool> BrickCounter::begin(const mesh::MeshShape& shape) {
  shape_ = shape;
  return shape.triangles > most_whole_;
}

Result<void> BrickCounter::take(const mesh::MeshPart& part) {
  std::vector<BrickCount> here;
  for (const glm::vec3& position : part.positions) {
    const glm::ivec3 brick = cells_.brick(index_from_output_(shape_.origin + glm::dvec3(position)));
    if (here.empty() || here.back().brick != brick) here.push_back({brick, 0});
    ++here.back().triangles;
  }
  merge_bricks(here);
  const std::lock_guard lock(mutex_);
  if (bricks_.size() + here.size() > most_) {
    merge_bricks(bricks_);
    most_ = 2 * (bricks_.size() + here.size());
    const std::uint64_t bytes = 2 * most_ * sizeof(BrickCount);  // twice while the list grows
    if (bytes > memory_.bytes())
      memory_.take(TRY(context_.reserve(bytes - memory_.bytes(), "the parts of the surface")));
  }
  bricks_.insert(bricks_.end(), here.begin(), here.end());
  return {};
}

std::vector<BrickCount> BrickCounter::take_bricks() {
  merge_bricks(bricks_);
  const double triangles_a_vertex = static_cast<double>(shape_.triangles) / static_cast<double>(shape_.vertices);
  for (BrickCount& brick : bricks_) {
    brick.triangles = static_cast<std::uint64_t>(triangles_a_vertex * static_cast<double>(brick.triangles));
  }
  return std::move(bricks_);
}

}  // namespace isoextract::accuracy
