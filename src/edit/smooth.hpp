// Smooths surfaces by low-pass filters of the vertex positions: removes noise and keeps the size of the shape.
//
// Positions are filtered as a signal on the mesh. Frequencies are the eigenvalues, 0 to 2, of I - W, where W is the
// mean of a vertex's neighbors. A plain mean shrinks the shape. Taubin and windowed sinc keep frequencies below the
// limit of the pass band, and damp higher frequencies.
//
// - Taubin: G. Taubin, A signal processing approach to fair surface design. SIGGRAPH 1995. Each pass takes a step
//   towards the mean by lambda and one away from it by mu, with 1/lambda + 1/mu = pass band. The transfer function is
//   ((1 - lambda k)(1 - mu k))^passes. Here lambda is 1/2.
// - Windowed sinc: G. Taubin, T. Zhang, G. Golub, Optimal surface smoothing as filter design. ECCV 1996. An ideal low
//   pass as a sum of Chebyshev polynomials up to degree `passes`, with a Hamming window against ripples. The
//   filter's cutoff moves above the pass band until the gain at the end of the pass band is at least 0.999. VTK's
//   vtkWindowedSincPolyDataFilter is the same filter.
// - Weighted: F. Loeschner, T. Boettcher, S. R. Jeske, J. Bender, Weighted Laplacian smoothing for surface
//   reconstruction of particle-based fluids. VMV 2023. Each pass moves a vertex towards the mean by its weight. This
//   shrinks shapes of a few edge lengths. So closed components get their volume back, as M. Desbrun, M. Meyer, P.
//   Schroeder, A. H. Barr do (Implicit fairing of irregular meshes using diffusion and curvature flow. SIGGRAPH 1999);
//   here the vertices move along their normals by their weights. Components with vertices that may not move freely
//   stay smaller. Other components that would lose more than four fifths of their volume are not smoothed.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "mesh/half_space.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

enum class SmoothMethod { taubin, sinc, weighted };
constexpr auto words_of(SmoothMethod /*type*/) {
  return std::array{Word{SmoothMethod::taubin, "taubin"}, Word{SmoothMethod::sinc, "sinc"},
                    Word{SmoothMethod::weighted, "weighted"}};
}

inline constexpr std::uint64_t kMaxSmoothPasses = 1000;
// Passes of SmoothMethod::weighted that average the normals, as splashsurf's documentation suggests.
inline constexpr int kNormalPasses = 10;

// The box of the data. Caps lie on its sides where the surface leaves the data. A position (Mesh::position(), origin
// included) has the box coordinates to_box * position + offset; the sides are at min and max.
struct DataBox {
  glm::dmat3 to_box{1.0};
  glm::dvec3 offset{0.0};
  glm::dvec3 min{0.0};
  glm::dvec3 max{0.0};
};

struct SmoothOptions {
  SmoothMethod method = SmoothMethod::taubin;
  std::uint64_t passes = 20;  // 1 to kMaxSmoothPasses
  double pass_band = 0.1;     // taubin, sinc: above 0, below 1
  // weighted: how far each vertex moves towards the mean of its neighbors in a pass, 0 to 1; one per vertex.
  std::span<const float> weights;
  // Vertices on a side of the box stay on that side, so caps stay flat.
  std::optional<DataBox> walls;
  // Vertices in these planes do not move: caps of cuts, and the edges along the cuts.
  std::span<const mesh::HalfSpace> cuts;
  // Maps the mesh's coordinates to the space in which the largest displacement is reported.
  glm::dmat3 to_metric{1.0};
};

struct SmoothFigures {
  std::uint64_t vertices = 0;
  std::uint64_t boundary_vertices = 0;  // on boundary edges, or in no triangle; they do not move
  std::uint64_t wall_vertices = 0;      // on sides of the box and in the planes of cuts
  std::uint64_t held_vertices = 0;      // moved less than the filter asks, so that no triangles intersect
  double greatest_move = 0;             // largest displacement in the space of to_metric
  double greatest_move_world = 0;       // largest displacement in the mesh's coordinates (perhaps of another vertex)
  double volume_before = 0;             // in the mesh's coordinates; meaningful only for closed meshes
  double volume_after = 0;
  std::uint64_t zero_area_before = 0;  // triangles without area: vertices can meet, or come to lie on one line
  std::uint64_t zero_area_after = 0;
  std::optional<double> mean_weight;  // weighted: the mean of the weights
  StageTime time;
};

// Moves the vertices of `mesh`. Recomputes existing normals from the triangles, weighted by angle (G. Thuermer and C.
// Wuethrich, Computing vertex normals from polygonal facets, 1998). SmoothMethod::weighted then averages the normals of
// freely moving vertices with those of their neighbors in kNormalPasses passes, by weight: the triangles of a smoothed
// surface are flat, while their normals still show the cells. Drops edge keys, as vertices leave their grid edges.
// Keeps triangles and attributes, so closed manifolds stay closed manifolds. The result does not depend on the number
// of threads. A vertex moves less, or not at all, if its move would make triangles intersect that did not before
// (detail/untangled_moves.hpp). Fails if the context is cancelled, or if memory is short: about 65 bytes a vertex and
// 24 a triangle (weighted, with normals: 85 and 48), plus the memory of the search for intersections.
[[nodiscard]] Result<SmoothFigures> smooth(mesh::Mesh& mesh, const SmoothOptions& options, const Context& context);

// Returns the filter's gain at a frequency from 0 to 2; for SmoothMethod::weighted, the gain at weight 1.
[[nodiscard]] double smoothing_gain(const SmoothOptions& options, double frequency);

}  // namespace isoextract::edit
