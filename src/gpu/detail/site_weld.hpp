// Welds captured triangles to an indexed mesh, by the key of the grid edge of each vertex.
//
// The result does not depend on the order or the portions in which triangles arrive. Vertices are numbered by site,
// direction and sample (extract/site_vertices.hpp), triangles by site and cell. If several sites captured a vertex, the
// mesh takes it from the site that owns its edge, else from the first site that has it.
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

// Returns the sites at +0 or +1 along x (bit 0), y (bit 1) and z (bit 2) from a site; -1 if there is no such site.
using NearSites = std::function<std::array<std::int32_t, 8>(std::size_t site)>;
// Returns the variant (CaseTable) of an ambiguous cell, given by its lowest sample.
using DecideCell = std::function<unsigned(const glm::ivec3& cell)>;

class SiteWeld {
 public:
  // `table` and `sites` must outlive this object.
  SiteWeld(const extract::CaseTable& table, std::span<const glm::ivec3> sites, NearSites near, DecideCell decide);

  // Adds the triangles of some sites. Site number k in their keys means sites[batch[k]]. Each site must be added once,
  // as a whole.
  void add(std::span<const std::uint32_t> batch, const CapturedSoup& soup);

  // Numbers vertices and triangles; call it once all sites are added. Fails with ErrorCode::unavailable if the captured
  // data are invalid: an edge that no site owns, a site that was not drawn, or an ambiguous cell without a vertex.
  [[nodiscard]] Result<extract::MeshSizes> number();

  // Writes the mesh to the start of arrays that have at least the sizes from number(). `mirrored` reverses the winding.
  void write(mesh::Mesh& mesh, bool mirrored) const;

  // Returns the vertex on the crossed edge from sample `offset` (block_offset()) of a site; valid after number().
  [[nodiscard]] std::uint32_t vertex_at(std::size_t site, int direction, int offset) const;

  // Returns the bytes of a weld of so many sites, without the data that add() keeps of each triangle.
  [[nodiscard]] static std::uint64_t bytes(std::size_t sites, std::size_t directions) {
    return extract::SiteVertices::bytes(sites, directions) +
           std::uint64_t{sites} * (sizeof(SiteRange) + sizeof(std::uint64_t));
  }
  [[nodiscard]] std::uint64_t piece_bytes() const { return piece_bytes_; }  // bytes that add() has kept so far

  [[nodiscard]] std::uint64_t decided_cells() const { return decided_cells_; }
  [[nodiscard]] const StageTime& time() const { return time_; }

 private:
  // Vertices and triangles of some sites. Vertices have local keys (direction << 12 | z << 8 | y << 4 | x), each once a
  // site.
  struct Piece {
    std::vector<std::uint16_t> keys;
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
    std::vector<std::array<std::uint16_t, 3>> triangles;  // indices of the site's vertices
    std::uint64_t decided = 0;
    bool incomplete = false;  // an ambiguous cell lacks some of its vertices

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
  struct BorrowedVertex {
    std::uint32_t site;
    std::uint32_t vertex;  // index in the piece
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
  bool has_unknown_sites_ = false;  // some triangles name a site outside their batch
  std::vector<SiteRange> ranges_;   // by site
  extract::SiteVertices vertices_;
  std::vector<std::uint64_t> first_triangle_;      // by site
  std::vector<BorrowedVertex> borrowed_vertices_;  // vertices that the owner of their edge did not capture
  std::uint64_t decided_cells_ = 0;
  StageTime time_;
};

}  // namespace isoextract::gpu
