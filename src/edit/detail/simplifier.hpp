// Simplifies a mesh, or a part of a mesh of which some edges are collapsed already, in rounds of patches
// (bounded_simplify.hpp tells how).
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "edit/bounded_simplify.hpp"
#include "edit/detail/collapse_state.hpp"
#include "edit/detail/distance_proof.hpp"
#include "edit/detail/edge_collapse.hpp"
#include "edit/detail/intersection_undo.hpp"
#include "edit/detail/patch_triangles.hpp"
#include "edit/detail/sheet_trees.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

// Adds the numbers of patches, collapses, rounds, passes and windows.
void add_counts(SimplifyFigures& sum, const SimplifyFigures& part);

class Simplifier {
 public:
  // The triangles of `mesh` are the original ones. Without `start`, the collapses begin there. Keeps references to all
  // but `start`, whose spans must outlive the simplifier. Sets all figures of `facts` but the triangles and the time.
  Simplifier(const mesh::Mesh& mesh, const Sheets& sheets, const SimplifyOptions& options, SimplifyFigures& facts,
             const Context& context, const CollapseStart* start = nullptr);

  // Collapses edges, and proves the distance unless it is infinite. Returns whether any triangle was removed. With
  // `start`, all distances must be within options.max_distance there.
  Result<bool> run();

  [[nodiscard]] CollapseState& state() { return state_; }
  [[nodiscard]] const std::vector<CollapseLog>& logs() const { return logs_; }

  // Returns the bytes that a simplifier takes, for the caller to reserve: the state and the logs, and the largest of
  // the lists of patches, proof and, with a target number of triangles, measurement.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t vertices, std::uint64_t triangles, bool has_target);
  // Returns the bytes that run() reserves besides, one after the other: for the patches at work, and to look for
  // intersections. Several threads take more if there is more. Without a target, patches are taken to be no larger than
  // usual.
  [[nodiscard]] static std::uint64_t bytes_at_work(std::uint64_t triangles, bool has_target);

 private:
  struct Share {
    double least_part = 0;   // fraction of each patch's triangles that must stay
    std::uint64_t work = 0;  // progress that the round reports; 0: the number of removed triangles
  };

  [[nodiscard]] bool is_changed() const;
  Result<UndoneIntersections> undo_new_intersections(std::span<const RestoredTriangle> restored,
                                                     bool is_guarded = true);
  Result<void> look(const Result<Proof>& proof);
  [[nodiscard]] std::vector<glm::vec3> place_vertices();
  Result<void> within(double enough);
  Result<void> sweep(double distance);
  Result<void> collapse_to_count(double enough);
  [[nodiscard]] double extent() const;
  Result<void> cheapest(double enough);
  Result<void> replace_worst(double enough);
  [[nodiscard]] DistanceProofOptions proof_options(double distance) const;
  Result<std::size_t> round(double size, const CollapseLimits& limits, const Share& share);
  Result<Reservation> reserve_patches(std::span<const std::size_t> first, std::size_t& workers) const;
  [[nodiscard]] std::vector<PatchTriangle> split(double size) const;
  void want_all();
  void lock_patch_borders(const std::vector<std::uint32_t>& triangles, const std::vector<std::size_t>& first);
  void want_patch_borders(const std::vector<std::uint32_t>& triangles, const std::vector<std::size_t>& first);

  const mesh::Mesh& mesh_;
  const SimplifyOptions& options_;
  SimplifyFigures& facts_;
  const Context& context_;
  std::span<const char> always_locked_;  // empty: none
  std::span<const char> first_wanted_;   // empty: all vertices
  std::size_t least_triangles_;          // sweeps keep so many triangles
  double slack_ = 0;                     // must stand before placed_, whose initializer sets it
  std::vector<glm::vec3> placed_;
  CollapseState state_;
  std::vector<char> locked_;
  std::vector<char> wanted_;
  std::vector<char> refused_;            // vertices that must stay to keep the distance; empty: none
  std::vector<std::uint32_t> patch_of_;  // one of each vertex's patches; threads decide which
  std::vector<CollapseLog> logs_;
  std::uint64_t numbers_ = 0;         // collapses numbered so far
  bool patches_are_checked_ = false;  // for intersections; a round needs a new check
  std::size_t left_;
  double farthest_squared_ = 0;  // largest squared distance of samples and new triangles
};

}  // namespace isoextract::edit
