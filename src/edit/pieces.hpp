// The pieces of a surface: small ones dropped, the largest kept, each as a mesh of its own.
//
// A piece is a body: a shell together with the walls of the cavities in it, as what is printed or simulated is. A shell
// is a component of the mesh that is closed; where its triangles face into the space that it closes off, it is the wall
// of a cavity. A component that is open is a piece by itself, and so is a cavity around which no shell is found. What
// lies loose in a cavity is a piece by itself.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "base/words.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

enum class PieceMeasure { triangles, area, volume };
constexpr auto words_of(PieceMeasure /*type*/) {
  return std::array{Word{PieceMeasure::triangles, "triangles"}, Word{PieceMeasure::area, "area"},
                    Word{PieceMeasure::volume, "volume"}};
}

// What goes, in this order.
struct PieceOptions {
  // Components of less, each measured by itself: a body goes with its cavities, a cavity that goes is filled. What is
  // of less by no more than the rounding of its vertices stays. Open components have no volume and stay where that is
  // what is measured.
  std::optional<double> least;
  PieceMeasure measure = PieceMeasure::triangles;
  bool fill_cavities = false;  // all of them
  // How many bodies stay: those of the largest area, their cavities not counted; of equal ones the first.
  std::optional<std::uint64_t> largest;
  // From the mesh's coordinates to the space in which areas and volumes are meant.
  glm::dmat3 to_metric{1.0};
};

struct PieceCounts {
  std::uint64_t triangles = 0;
  std::uint64_t components = 0;
  std::uint64_t bodies = 0;  // with the open components; the other components are walls of cavities
};

struct PieceFacts {
  PieceCounts before;
  PieceCounts after;
  std::uint64_t without_volume = 0;  // open components that stayed because volume was measured
  StageTime time;
};

struct KeptPieces {
  mesh::Mesh mesh;
  PieceFacts facts;
};

// Positions in place of a mesh's own, one for each vertex, that decide which components are walls of cavities, in which
// bodies they lie, and how large they are: of a mesh whose vertices were moved off the places where the field puts
// them. Empty: the mesh's own.
using Sites = Buffer<glm::vec3>;

// The vertices and triangles of what stays, in their order and with all that belongs to them; where all stays, the
// mesh. A filled cavity takes what lies in it along. No triangle is changed: what was closed is closed. The same for
// any number of threads. Fails where the memory for it is not there.
[[nodiscard]] Result<KeptPieces> keep_pieces(mesh::Mesh mesh, const PieceOptions& options, const Context& context,
                                             Sites sites = {});

// Adds an attribute that holds the body of each vertex, for split_pieces(). Stages that move or leave out vertices, but
// join no components, may follow: cavities stay with their bodies. Fails where the memory for it is not there.
[[nodiscard]] Result<void> mark_bodies(mesh::Mesh& mesh, const Context& context, Sites sites = {});

// Each piece as a mesh, the largest area first, with all that belongs to its vertices but that attribute; none of a
// mesh without triangles. Without the attribute the mesh as it is says which cavity is in which body. Names are the
// mesh's. Fails where the memory is not there for all of them beside the mesh, and where there are more than `most`:
// nothing is made then.
[[nodiscard]] Result<std::vector<mesh::Mesh>> split_pieces(mesh::Mesh mesh, std::uint64_t most, const Context& context);

}  // namespace isoextract::edit
