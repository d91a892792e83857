// From captured triangles to an indexed mesh, by the key of the grid edge that each vertex lies on.
//
// The result depends on what was captured, not on the order or the portions in which it came: vertices are numbered by
// site, direction and sample (extract/site_vertices.hpp), triangles by site and cell. A vertex that several sites
// captured is taken from the site that owns its edge, else from the first that has it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "extract/cell_tables.hpp"
#include "extract/mesh_assembly.hpp"
#include "extract/site_vertices.hpp"
#include "gpu/detail/cell_capture.hpp"

namespace isoextract::gpu {

// For each site the sites at +0 or +1 places along x (bit 0), y (bit 1) and z (bit 2); -1 if that is no site.
using NearSites = std::function<std::array<std::int32_t, 8>(std::size_t site)>;
// What the ambiguous cell at a sample draws: a variant of CaseTable.
using DecideCell = std::function<unsigned(const glm::ivec3& cell)>;

class SiteWeld {
 public:
  SiteWeld(const extract::CaseTable& table, std::span<const glm::ivec3> sites, NearSites near, DecideCell decide);

  // Triangles of some sites; the site number k in their keys stands for sites[batch[k]]. Each site comes whole, once.
  void add(std::span<const std::uint32_t> batch, const CapturedSoup& soup);

  // Once all were added. Fails with ErrorCode::unavailable if what was captured cannot be: an edge that no site
  // owns, a site that was not drawn.
  [[nodiscard]] Result<extract::MeshSizes> number();

  // Into the first vertices and triangles of a mesh that was allocated by those sizes; mirrored frames turn triangles
  // over.
  void write(mesh::Mesh& mesh, bool mirrored) const;

  // After number(): the vertex on the crossed edge from sample `offset` (block_offset()) of a site.
  [[nodiscard]] std::uint32_t vertex_at(std::size_t site, int direction, int offset) const;

  // What a weld of so many sites takes, but for what add() keeps of each
  // triangle.
  [[nodiscard]] static std::uint64_t bytes(std::size_t sites, std::size_t directions) {
    return extract::SiteVertices::bytes(sites, directions) +
           std::uint64_t{sites} * (sizeof(SiteRange) + sizeof(std::uint64_t));
  }
  [[nodiscard]] std::uint64_t piece_bytes() const { return piece_bytes_; }  // what it has kept so far

  [[nodiscard]] std::uint64_t decided_cells() const { return decided_cells_; }
  [[nodiscard]] const StageTime& time() const { return time_; }

 private:
  // What some sites draw: vertices by local key (direction << 12 | z << 8 | y << 4 | x), each once a site.
  struct Piece {
    std::vector<std::uint16_t> keys;
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
    std::vector<std::array<std::uint16_t, 3>> triangles;  // of the site's vertices
    std::uint64_t decided = 0;
    bool incomplete = false;  // an ambiguous cell without all its vertices

    [[nodiscard]] std::uint64_t bytes() const;
  };
  struct SiteRange {
    std::uint32_t piece = 0;
    std::uint32_t first_vertex = 0, vertices = 0;
    std::uint32_t first_triangle = 0, triangles = 0;
  };
  struct EdgeOwner {
    std::int32_t site;
    std::uint32_t direction;  // index into CaseTable::directions
    int offset;
  };
  struct LateVertex {
    std::uint32_t site;
    std::uint32_t vertex;  // of the piece
    EdgeOwner owner;
  };
  class LocalVertices;

  void weld_site(std::uint32_t site, const CapturedSoup& soup, std::span<const std::uint32_t> triangles,
                 LocalVertices& local, Piece& piece);
  [[nodiscard]] EdgeOwner owner_of(const std::array<std::int32_t, 8>& near, std::uint16_t key) const;

  const extract::CaseTable& table_;
  std::span<const glm::ivec3> sites_;
  NearSites near_;
  DecideCell decide_;
  std::vector<Piece> pieces_;
  std::uint64_t piece_bytes_ = 0;
  bool strangers_ = false;         // triangles of a site that is not in their batch
  std::vector<SiteRange> ranges_;  // by site
  extract::SiteVertices vertices_;
  std::vector<std::uint64_t> first_triangle_;  // by site
  std::vector<LateVertex> late_;               // not captured by their owner
  std::uint64_t decided_cells_ = 0;
  StageTime time_;
};

}  // namespace isoextract::gpu
