// The vertices of a voxel surface: grid corners, numbered by position.
//
// A corner is used if it is a corner of a rectangle, or if it ends a grid edge along which two voxels touch without a
// common face. So the mesh edges between such voxels are one step long. Each fan of faces (corner_fans.hpp) has its own
// vertex. If two voxels touch along an edge and are in one fan at both of its ends, that mesh edge would have four
// triangles. Each of the two voxels then gets an extra vertex in the middle of the edge.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "extract/detail/corner_fans.hpp"
#include "extract/detail/face_rectangles.hpp"
#include "extract/detail/net_points.hpp"
#include "extract/detail/voxel_chunks.hpp"
#include "extract/edge_geometry.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::extract {

// A grid corner and one of the faces around it (numbers as in corner_fans.hpp).
struct FaceCorner {
  glm::ivec3 corner;
  int face = 0;
};

class SurfacePoints {
 public:
  // Numbers the vertices of `rectangles`, which list_face_rectangles() made with `faces`. Unless `faces` is
  // VoxelFaces::rectangles, adds the vertices that a closed mesh needs besides the rectangle corners. A `net`, which
  // requires VoxelFaces::plain, gives the positions of corners; null: corners stay at the voxel corners. `net` must
  // outlive the result. Fails if memory runs out and if the context is cancelled.
  [[nodiscard]] static Result<SurfacePoints> make(const VoxelChunks& voxels,
                                                  const std::vector<LayerRectangles>& rectangles, VoxelFaces faces,
                                                  const NetPoints* net, const Context& context,
                                                  const std::string& what);

  [[nodiscard]] std::uint64_t vertices() const { return vertices_; }
  // Returns whether any edge has vertices in its middle.
  [[nodiscard]] bool has_middles() const { return has_middles_; }

  // Writes the vertex positions in parallel; `base` is the sample index of voxel 0.
  void write_positions(const OutputPlacement& placement, const glm::ivec3& base, mesh::Mesh& mesh) const;

  // Looks up vertices of corners; fast if consecutive corners are in the same chunk.
  class Finder {
   public:
    explicit Finder(const SurfacePoints& points) : points_(points) {}

    // Returns the vertex of a used corner.
    [[nodiscard]] std::uint32_t vertex(const FaceCorner& at);

    // Calls found(vertex, steps), in order, for the vertices strictly between the used corner `from` and the corner
    // `length` grid steps further along `axis`. `steps` counts half grid steps. `upper` is 1 if the face's voxel is on
    // the upper side of the edge along the lower one of the other two axes, else 0.
    template <class Found>
    void along(const FaceCorner& from, int axis, int length, int upper, const Found& found) {
      FaceCorner at = from;
      for (int steps = 0; steps < length;) {
        if (const auto middle = middle_vertex(at.corner, axis, upper)) found(*middle, 2 * steps + 1);
        steps += steps_to_next(at.corner, axis, length - steps);
        if (steps >= length) return;
        at.corner[axis] = from.corner[axis] + steps;
        found(vertex(at), 2 * steps);
      }
    }

   private:
    void go_to(const glm::ivec3& corner);
    [[nodiscard]] std::size_t chunk() const { return static_cast<std::size_t>(chunk_); }
    [[nodiscard]] std::optional<std::uint32_t> middle_vertex(const glm::ivec3& corner, int axis, int upper);
    [[nodiscard]] int steps_to_next(const glm::ivec3& corner, int axis, int limit);

    const SurfacePoints& points_;
    glm::ivec3 origin_{1};     // no chunk has this origin
    std::int32_t chunk_ = -1;  // the chunk at origin_; -1 if no corner there is used
  };

 private:
  // Vertices of a chunk beyond one for each used corner.
  struct Specials {
    std::array<ChunkBits, 2> more_fans;         // number of fans minus one, as two binary digits
    std::array<ChunkBits, 3> middles;           // edges upward along x, y, z with extra vertices in the middle
    std::array<ChunkBits, 3> single_middles;    // the edges of `middles` with one such vertex, not two (nets only)
    std::array<std::uint8_t, 64 * 64> pattern;  // pattern of each used corner, by row and bit
  };
  using RowBases = std::array<std::uint32_t, 64>;

  static constexpr std::int32_t kNoSpecials = -1;

  [[nodiscard]] static Result<std::vector<glm::ivec3>> list_origins(const VoxelChunks& voxels,
                                                                    const std::vector<LayerRectangles>& rectangles,
                                                                    bool closes, const Context& context,
                                                                    const std::string& what, Reservation& memory);
  void mark_corners(const std::vector<LayerRectangles>& rectangles);
  void mark(std::size_t chunk, const glm::ivec3& corner);
  [[nodiscard]] bool has_specials(const VoxelChunks& voxels, std::size_t chunk, bool closes) const;
  void fill_specials(const VoxelChunks& voxels, std::size_t chunk, bool closes);
  void count_rows(std::size_t chunk);
  // Returns the position of a corner in index space. `net_chunk`: the number of its chunk in the net, if there is one.
  [[nodiscard]] glm::dvec3 place_of(const glm::ivec3& base, std::int32_t net_chunk, const glm::ivec3& corner) const;
  void write_chunk(const OutputPlacement& placement, const glm::ivec3& base, mesh::Mesh& mesh, std::size_t chunk) const;
  [[nodiscard]] std::uint32_t vertices_below(std::size_t chunk, std::size_t row, std::uint64_t below) const;

  const NetPoints* net_ = nullptr;
  std::vector<glm::ivec3> origins_;
  field::OriginIndex index_;
  Buffer<ChunkBits> used_;
  Buffer<RowBases> first_;  // number of the first vertex of each row
  Buffer<std::int32_t> special_number_;
  Buffer<Specials> specials_;
  std::vector<Reservation> memory_;
  std::uint64_t vertices_ = 0;
  bool has_middles_ = false;
};

}  // namespace isoextract::extract
