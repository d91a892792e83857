// Figures of a written mesh for the report: size, topology, components.
#pragma once

#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/stage_report.hpp"
#include "convert/stages/surface_stages.hpp"

namespace isoextract::convert {

// Returns the figures. Closedness and defects of edges and vertices are those that readers of the file find
// (Surface::welded). Vertices, components and genus are those of the mesh before welding. Takes Surface::measures if
// set, else measures the mesh. Fails if memory runs out.
[[nodiscard]] Result<Figures> mesh_facts(Surface& surface, const Context& context);

// Returns Surface::facts with the figures known only when the mesh is written: file, mesh name, number of vertices in
// the file, the error if it was measured, and the grid if the job has several.
[[nodiscard]] Figures facts_as_written(const Surface& surface, const std::string& file, const std::string& grid);

}  // namespace isoextract::convert
