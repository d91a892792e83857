// Smoother surfaces by low-pass filters of the vertices' places: what is noise goes, what is shape keeps its size.
//
// Places are filtered as a signal on the mesh, whose frequencies are the eigenvalues, 0 to 2, of I - W; W is the mean
// of a vertex' neighbours. A plain mean shrinks; these pass what is below the pass band and damp what is above.
//
// - Taubin: G. Taubin, A signal processing approach to fair surface design. SIGGRAPH 1995. A step towards the mean by
//   lambda, one away from it by mu, with 1/lambda + 1/mu = pass band: the transfer function is
//   ((1 - lambda k)(1 - mu k))^passes. Here lambda is 1/2.
// - Windowed sinc: G. Taubin, T. Zhang, G. Golub, Optimal surface smoothing as filter design. ECCV 1996. The ideal low
//   pass as a sum of Chebyshev polynomials up to degree `passes`, with a Hamming window against its ripples; the step
//   is moved so far that the pass band is passed whole. It is that of VTK's vtkWindowedSincPolyDataFilter.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "base/words.hpp"
#include "mesh/half_space.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

enum class SmoothMethod { taubin, sinc };
constexpr auto words_of(SmoothMethod /*type*/) {
  return std::array{Word{SmoothMethod::taubin, "taubin"}, Word{SmoothMethod::sinc, "sinc"}};
}

inline constexpr std::uint64_t kMaxSmoothPasses = 1000;

// A box of which the surface may have parts in common, the caps where it leaves the data.
struct SmoothWalls {
  glm::dmat3 to_box{1.0};  // from the mesh's coordinates, origin included, to those of the box
  glm::dvec3 offset{0.0};
  glm::dvec3 min{0.0};
  glm::dvec3 max{0.0};
};

struct SmoothOptions {
  SmoothMethod method = SmoothMethod::taubin;
  std::uint64_t passes = 20;  // 1 to kMaxSmoothPasses
  double pass_band = 0.1;     // above 0, below 1
  // Vertices on a side of the box stay on it: caps stay flat.
  std::optional<SmoothWalls> walls;
  // Vertices in their planes stay where they are: the caps of cuts, and what they were cut along.
  std::span<const mesh::HalfSpace> cuts;
  // From the mesh's coordinates to the space in which the greatest displacement is told.
  glm::dmat3 to_metric{1.0};
};

struct SmoothFacts {
  std::uint64_t vertices = 0;
  std::uint64_t border_vertices = 0;  // of open borders, which stay where they are
  std::uint64_t wall_vertices = 0;    // on sides of the box and in the planes of cuts
  double greatest_move = 0;           // of a vertex, in the space of to_metric
  double greatest_move_world = 0;     // and in the mesh's own
  double volume_before = 0;           // of the mesh's coordinates; they mean something where it is closed
  double volume_after = 0;
  StageTime time;
};

// Moves the vertices of `mesh`, and makes its normals anew from the triangles, weighted by their angles (G. Thuermer
// and C. Wuethrich, Computing vertex normals from polygonal facets, 1998), where it has any. Triangles and everything
// else stay: what was closed and manifold is so. Edge keys go, as vertices lie on edges no more. The same for any
// number of threads. Fails where the memory for it is not there, some 56 bytes a vertex and 24 a triangle, and where
// the context is cancelled.
[[nodiscard]] Result<SmoothFacts> smooth(mesh::Mesh& mesh, const SmoothOptions& options, const Context& context);

// What the filter leaves of a frequency from 0 to 2.
[[nodiscard]] double smoothing_gain(const SmoothOptions& options, double frequency);

}  // namespace isoextract::edit
