// Simplifies the meshes of several labels together, so that labels that touch keep the same triangles on their common
// faces, with opposite winding.
//
// The meshes are joined to a net: each triangle that two labels have in common is in it once. Its sheets, the triangles
// between the same two labels, meet in curves, for example where three labels meet. An edge of a curve is kept or
// collapsed for all its sheets at once, and the ends of curves stay (detail/edge_collapse.hpp). Each label then takes
// its triangles from the net.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "edit/bounded_simplify.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

struct CollapsedSheets;
enum class VertexRole : std::uint8_t;

class LabelNet {
 public:
  // Joins meshes, one for each label, which must stay unchanged until simplify(). Vertices at equal positions become
  // one vertex of the net; all meshes need the same origin and finite positions. Fails with ErrorCode::out_of_memory,
  // and with ErrorCode::input if the meshes together have 2^32 - 1 vertices or triangles or more.
  [[nodiscard]] static Result<LabelNet> join(std::span<mesh::Mesh* const> meshes, const Context& context);

  // Returns the number of triangles; one that two labels have in common counts once.
  [[nodiscard]] std::uint64_t triangles() const { return net_.triangles.size(); }
  // Returns the number of sheets.
  [[nodiscard]] std::uint64_t sheets() const { return sheets_; }

  // Simplifies the meshes given to join(), in the same order, as simplify_mesh() does, and returns the figures of the
  // net. SimplifyOptions::triangles counts triangles of the net. The distance bounds hold for each sheet and so for
  // the mesh of each label, in both directions between input and result.
  //
  // Each mesh keeps a subset of its vertices, and its topology. Triangles of one label only, as in cut or smoothed
  // meshes, form sheets of their own. Vertices stay where a curve ends, and where a label touches itself other than
  // along a curve. Fails as simplify_mesh() does; if memory is short, some of the meshes may then be simplified.
  [[nodiscard]] Result<SimplifyFigures> simplify(std::span<mesh::Mesh* const> meshes, const SimplifyOptions& options,
                                                 const Context& context) const;

 private:
  // Maps one mesh to the net.
  struct Part {
    std::vector<std::uint32_t> vertices;   // for each vertex of the mesh: its number in the net
    std::vector<std::uint32_t> triangles;  // for each triangle of the mesh: its number in the net
  };

  [[nodiscard]] static LabelNet joined(std::span<mesh::Mesh* const> meshes, std::size_t vertices,
                                       std::size_t triangles);
  void join_vertices(std::span<mesh::Mesh* const> meshes, std::size_t vertices);
  void join_triangles(std::span<mesh::Mesh* const> meshes, std::size_t triangles);
  void set_roles(const mesh::Mesh& mesh, const Part& part);
  void take_triangles(mesh::Mesh& mesh, const Part& part, const CollapsedSheets& collapsed,
                      std::span<const char> there) const;

  mesh::Mesh net_;
  std::vector<Part> parts_;
  std::vector<std::uint32_t> sheet_of_;  // for each triangle of the net
  std::vector<VertexRole> roles_;        // of the vertices of the net
  std::uint32_t sheets_ = 0;
  Reservation memory_;
};

}  // namespace isoextract::edit
