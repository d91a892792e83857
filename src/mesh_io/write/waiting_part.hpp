// A part of a mesh that waits for the vertices of the next part, to which its triangles refer.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh_sink.hpp"

namespace isoextract::mesh_io {

class WaitingPart {
 public:
  // `name` is that of the file, for messages.
  WaitingPart(const Context& context, std::string name) : context_(context), name_(std::move(name)) {}

  // Call before the first part. This and keep() fail with ErrorCode::out_of_memory.
  [[nodiscard]] Result<void> begin(const mesh::MeshShape& shape) {
    far_memory_ = TRY(reserve(shape.far_vertices.size() * (sizeof(std::uint32_t) + sizeof(glm::vec3))));
    far_ = shape.far_vertices;
    far_positions_.resize(far_.size());
    return {};
  }

  // Keeps a copy of this part instead of the one before. The parts come in order, with positions and triangles.
  [[nodiscard]] Result<void> keep(const mesh::MeshPart& part) {
    // The vectors keep the room of their largest part; a larger part replaces it.
    const std::size_t vertices = std::max(part.positions.size(), positions_.capacity());
    const std::size_t triangles = std::max(part.triangles.size(), triangles_.capacity());
    const std::uint64_t bytes = vertices * sizeof(glm::vec3) + triangles * sizeof(glm::uvec3);
    if (bytes > memory_.bytes()) memory_.take(TRY(reserve(bytes - memory_.bytes())));
    if (vertices > positions_.capacity()) positions_ = {};
    if (triangles > triangles_.capacity()) triangles_ = {};
    first_vertex_ = part.first_vertex;
    positions_.assign(part.positions.begin(), part.positions.end());
    triangles_.assign(part.triangles.begin(), part.triangles.end());
    for (std::size_t f = far_place(first_vertex_); f < far_place(first_vertex_ + positions_.size()); ++f) {
      far_positions_[f] = positions_[far_[f] - first_vertex_];
    }
    return {};
  }

  [[nodiscard]] std::span<const glm::uvec3> triangles() const { return triangles_; }
  // Returns the corners of a triangle of the part; `next` are the positions of the next part.
  [[nodiscard]] std::array<glm::vec3, 3> corners(std::size_t triangle, std::span<const glm::vec3> next) const {
    const glm::uvec3& t = triangles_[triangle];
    return {position(t.x, next), position(t.y, next), position(t.z, next)};
  }

 private:
  [[nodiscard]] Result<Reservation> reserve(std::uint64_t bytes) const {
    return context_.reserve(bytes, name_ + ": a part of the mesh");
  }

  [[nodiscard]] glm::vec3 position(std::uint32_t vertex, std::span<const glm::vec3> next) const {
    if (vertex < first_vertex_) return far_positions_[far_place(vertex)];
    const std::uint64_t place = vertex - first_vertex_;
    return place < positions_.size() ? positions_[place] : next[place - positions_.size()];
  }

  // Returns the number of far vertices before a vertex.
  [[nodiscard]] std::size_t far_place(std::uint64_t vertex) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(far_, vertex) - far_.begin());
  }

  Context context_;
  std::string name_;
  Reservation far_memory_;
  std::vector<std::uint32_t> far_;  // MeshShape::far_vertices
  std::vector<glm::vec3> far_positions_;
  Reservation memory_;  // for the part
  std::uint64_t first_vertex_ = 0;

  std::vector<glm::vec3> positions_;
  std::vector<glm::uvec3> triangles_;
};

}  // namespace isoextract::mesh_io
