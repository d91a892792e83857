// The vertices of a surface of voxels: corners of the grid, numbered by their place.
//
// A corner is used where a rectangle has a corner of its own there, and wherever voxels touch along an edge only, so
// that such edges are one step long. Each fan of faces (corner_fans.hpp) has a vertex of its own. Where voxels touch
// along an edge and are in one fan at both of its ends, that edge of the mesh would have four triangles: each of the
// two gets a vertex in its middle, too.
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

// A corner of the grid, and one of the faces around it by its number there (corner_fans.hpp).
struct FaceCorner {
  glm::ivec3 corner;
  int face = 0;
};

class SurfacePoints {
 public:
  // Of `rectangles`. `closes`: all that a closed mesh needs besides their corners. `net`: corners are where it has
  // them, and rectangles are faces of their own; null: where the voxels have them. It must outlive what is returned.
  // Fails where there is no memory, and where the context is cancelled.
  [[nodiscard]] static Result<SurfacePoints> make(const VoxelChunks& voxels,
                                                  const std::vector<LayerRectangles>& rectangles, bool closes,
                                                  const NetPoints* net, const Context& context,
                                                  const std::string& what);

  [[nodiscard]] std::uint64_t vertices() const { return vertices_; }

  // Chunk by chunk, in parallel; `base` is the sample that voxel 0 is.
  void write_positions(const OutputFrame& placement, const glm::ivec3& base, mesh::Mesh& mesh) const;

  // Looks corners up, one near the other.
  class Finder {
   public:
    explicit Finder(const SurfacePoints& points) : points_(points) {}

    // The vertex of a used corner.
    [[nodiscard]] std::uint32_t vertex(const FaceCorner& at);

    // found(vertex, steps) for the vertices strictly between `from`, which is used, and the corner `length` steps along
    // `axis`, in this order; steps are halves. `upper` is the side of the face's voxel along the lower axis across.
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
    glm::ivec3 origin_{1};     // of no chunk
    std::int32_t chunk_ = -1;  // there: none, where no corner is used
  };

 private:
  // What corners of a chunk have besides one vertex each.
  struct Specials {
    std::array<ChunkBits, 2> more_fans;         // one fewer than there are, as two digits
    std::array<ChunkBits, 3> middles;           // edges upward along x, y, z with a vertex a voxel in the middle
    std::array<ChunkBits, 3> single_middles;    // those of them with one vertex there: of a net
    std::array<std::uint8_t, 64 * 64> pattern;  // by row and bit
  };
  using RowBases = std::array<std::uint32_t, 64>;

  static constexpr std::int32_t kNoSpecials = -1;

  [[nodiscard]] static Result<std::vector<glm::ivec3>> list_origins(const VoxelChunks& voxels,
                                                                    const std::vector<LayerRectangles>& rectangles,
                                                                    bool closes, const Context& context,
                                                                    const std::string& what, Reservation& memory);
  void mark(const glm::ivec3& corner);
  void mark_contacts(const VoxelChunks& voxels, std::size_t chunk);
  [[nodiscard]] bool has_specials(const VoxelChunks& voxels, std::size_t chunk, bool closes) const;
  void fill_specials(const VoxelChunks& voxels, std::size_t chunk, bool closes);
  void count_rows(std::size_t chunk);
  [[nodiscard]] glm::dvec3 place_of(const glm::ivec3& base, const glm::ivec3& corner) const;  // in index space
  void write_chunk(const OutputFrame& placement, const glm::ivec3& base, mesh::Mesh& mesh, std::size_t chunk) const;
  [[nodiscard]] std::uint32_t vertices_below(std::size_t chunk, std::size_t row, std::uint64_t below) const;

  const NetPoints* net_ = nullptr;
  std::vector<glm::ivec3> origins_;
  field::OriginIndex index_;
  Buffer<ChunkBits> used_;
  Buffer<RowBases> first_;  // the first vertex of a row
  Buffer<std::int32_t> special_number_;
  Buffer<Specials> specials_;
  std::vector<Reservation> memory_;
  std::uint64_t vertices_ = 0;
};

}  // namespace isoextract::extract
