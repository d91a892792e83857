// The stages between the extraction of a surface and its file, one after the other.
#pragma once

#include <optional>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"
#include "convert/mesh_error.hpp"
#include "convert/source.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

struct Surface {
  double iso = 0;
  mesh::Mesh mesh;
  std::optional<MeshError> error;
};

// How the surface of `source` at an iso value is extracted for `job`.
[[nodiscard]] extract::ExtractOptions extract_options_of(const ConversionJob& job, const Source& source, double iso);

// Gives the vertices their attributes, changes the mesh as the job asks for, colours what came of it and measures its
// error. `isos` are those of all surfaces of the job. Tells of each stage. Fails as the stages do.
[[nodiscard]] Result<void> finish_surface(const ConversionJob& job, const Source& source,
                                          const std::vector<double>& isos, const Context& context, Events& events,
                                          Surface& surface);

}  // namespace isoextract::convert
