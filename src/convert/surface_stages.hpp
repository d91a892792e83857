// The stages between the extraction of a surface and its file, one after the other.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"
#include "convert/label_looks.hpp"
#include "convert/mesh_error.hpp"
#include "convert/source.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

struct Surface {
  double iso = 0;
  mesh::Mesh mesh;
  std::optional<MeshError> error;
  std::optional<MeshRecord> record;         // where one was asked for; of the mesh before vertices were copied
  StageTime recording;                      // what that took
  bool counts_open_edges = false;           // only a look at the mesh says whether it is closed
  std::optional<std::uint64_t> open_edges;  // then, before vertices were copied
  double simplified_by = 0;                 // voxels: how far simplification moved it at most
};

// What is known of all surfaces, and of the one at hand.
struct SurfaceFacts {
  std::span<const double> isos;        // of all surfaces of the job
  bool may_be_open = false;            // it may have a border
  bool recorded = false;               // a MeshRecord of it is asked for
  const LabelLooks* labels = nullptr;  // where the iso values are labels: how these look
};

// How the surface of `source` at an iso value is extracted for `job`.
[[nodiscard]] extract::ExtractOptions extract_options_of(const ConversionJob& job, const Source& source, double iso);

// Gives the vertices their attributes, changes the mesh as the job asks for, colours what came of it and measures its
// error. A mesh that is split into pieces is left without what shade_surface() does: each piece is to have its own.
// Tells of each stage. Fails as the stages do.
[[nodiscard]] Result<void> finish_surface(const ConversionJob& job, const Source& source, const SurfaceFacts& facts,
                                          const Context& context, Events& events, Surface& surface);

// Records the mesh where that is asked for, and makes its normals fit its triangles: last of all, for vertices may be
// copied for that, which makes open edges.
[[nodiscard]] Result<void> shade_surface(const ConversionJob& job, const Source& source, bool recorded,
                                         const Context& context, Events& events, Surface& surface);

}  // namespace isoextract::convert
