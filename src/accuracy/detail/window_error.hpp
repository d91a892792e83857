// Measures the distances between a mesh and an isosurface in one window, brick by brick.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "accuracy/detail/brick_members.hpp"
#include "accuracy/detail/gradient_search.hpp"
#include "accuracy/detail/search_window.hpp"
#include "accuracy/detail/subdivided_surface.hpp"
#include "accuracy/detail/surface_foot.hpp"
#include "accuracy/detail/surface_to_mesh.hpp"
#include "accuracy/error_statistics.hpp"
#include "accuracy/field_error.hpp"
#include "accuracy/index_mesh.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::accuracy {

// Shared data of all windows of a measurement.
struct ErrorReference {
  ErrorReference(const field::ScalarField& field, const extract::ExtractOptions& extracted,
                 const FieldErrorOptions& options, const field::Affine& output_from_index);

  const field::ScalarField& field;
  const extract::ExtractOptions& extracted;
  const FieldErrorOptions& options;
  field::Affine output_from_index;
  field::Interpolant chosen;
  field::Interpolant trilinear;
  CellFinder cells;
  glm::dvec3 width{0.0};                  // cell width between opposite faces, in the mesh's units
  double shortest = 0;                    // least length of a one-voxel step, in the mesh's units
  double diagonal = 0;                    // upper bound of the distance of two points of a cell, in the mesh's units
  double voxel = 0;                       // IndexMesh::voxel()
  std::optional<field::IndexBox> region;  // of the isosurface
  bool counted = true;                    // whether coverage is measured in that region
  bool has_mesh = true;                   // whether the mesh has triangles
  int parts = 0;                          // subcells of a cell along each axis
};

struct FieldSums {
  ErrorAccumulator interior;
  ErrorAccumulator vertices;
  ErrorAccumulator storage;
  SurfaceToMeshSums back;
  std::uint64_t cap_triangles = 0;
  // Distance within which the nearest points of the isosurface are, if its window is too small to find all; else 0. For
  // the mesh, this is back.needed.
  double needed = 0;

  void merge(const FieldSums& other);
};
// Returns sums without points.
[[nodiscard]] FieldSums no_sums(const ErrorReference& reference);

class WindowError {
 public:
  // `surface`, the isosurface on undivided cells, is the part within `surface_window`, and `mesh` that within
  // `mesh_window`. Both windows have the same bricks. All arguments must outlive the object.
  WindowError(const ErrorReference& reference, const SearchWindow& surface_window, const SearchWindow& mesh_window,
              const mesh::Mesh& mesh, const mesh::Mesh& surface, const Context& context);

  // Reserves memory, and builds the trees. Call it first. Throws std::bad_alloc, as measure() does.
  [[nodiscard]] Result<void> prepare();
  // Returns the sums of the points in the bricks of the windows. If a distance is needed, a window is too small to find
  // all nearest points, and the sums are incomplete. `progress` may be null.
  [[nodiscard]] Result<FieldSums> measure(Progress* progress);

  [[nodiscard]] const IndexMesh& placed() const { return placed_; }
  [[nodiscard]] const mesh::TriangleTree* surface_tree() const { return surface_tree_ ? &*surface_tree_ : nullptr; }
  [[nodiscard]] std::size_t brick_count() const { return bricks_.size(); }

  // Returns the memory in use at a time, without both meshes and the bricks.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t mesh_triangles, std::uint64_t mesh_vertices,
                                           std::uint64_t surface_triangles, std::uint64_t surface_vertices);

 private:
  // One brick, its surface, and the searches in it.
  struct Brick {
    glm::ivec3 at{0};
    SubdividedSurface surface;
    field::IndexBox box;  // the samples of the surface's cells
    FieldFootFinder foot;
    GradientSearch search;
    std::uint32_t near = 0;        // slot of the last nearest triangle
    std::uint32_t near_whole = 0;  // slot of the last nearest triangle of the surface in whole cells
  };

  // Returns the memory of all bricks measured at a time.
  [[nodiscard]] std::uint64_t bricks_bytes() const;
  void list_bricks();
  void measure_brick(const glm::ivec3& at, FieldSums& sums);
  [[nodiscard]] GradientSearch search_in(const field::Interpolant& interpolant) const;

  // Measures from `index` to the nearest isosurface point in the brick, and in the window if that may be nearer.
  // Returns the distance that the window needs: 0 if it was large enough.
  double measure_point(const glm::dvec3& index, double weight, Brick& brick, ErrorAccumulator& into) const;
  // Returns the distance of a point from the nearest face of `box`, leaving out faces on the data boundary.
  [[nodiscard]] double distance_inside(const glm::dvec3& index, const field::IndexBox& box) const;
  void search_in_brick(const glm::dvec3& index, Brick& brick, std::optional<glm::dvec3>& step) const;
  // Returns the distance that the window needs.
  double search_window(const glm::dvec3& index, Brick& brick, std::optional<glm::dvec3>& step) const;
  // Replaces `step` by the way to the foot of `index` found from `near`, if that is shorter.
  static void keep_nearer_foot(const glm::dvec3& index, const glm::dvec3& near, double reach, FieldFootFinder& foot,
                               std::optional<glm::dvec3>& step);
  // Measures the points of a triangle that are in the brick. Other bricks measure its other points.
  void measure_triangle(std::size_t triangle, Brick& brick, FieldSums& sums) const;
  void measure_vertices(Brick& brick, FieldSums& sums) const;
  void measure_from_surface(Brick& brick, FieldSums& sums) const;

  const ErrorReference& reference_;
  const SearchWindow& window_;  // of the isosurface
  const SearchWindow& mesh_window_;
  const mesh::Mesh& mesh_;
  const mesh::Mesh& surface_;
  const Context& context_;
  IndexMesh placed_;
  glm::dmat3 index_from_step_;
  Reservation memory_;
  Reservation bricks_memory_;
  std::optional<mesh::TriangleTree> surface_tree_;
  std::optional<mesh::TriangleTree> mesh_tree_;
  std::vector<BrickMember> triangles_;
  std::vector<BrickMember> vertices_;
  std::vector<std::uint8_t> surface_vertices_;
  std::vector<BrickCount> bricks_;

  std::atomic<bool> failed_{false};
  std::atomic<bool> is_too_small_{false};  // a window is: the remaining bricks need not be measured
  std::mutex error_mutex_;
  std::optional<Error> error_;
};

}  // namespace isoextract::accuracy
