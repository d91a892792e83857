// Figures of a written mesh for the report: size, topology, components.
#pragma once

#include <optional>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/stage_report.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

// Returns the figures. Edges and vertices are those that readers of the file find (Surface::welded); components are
// those of the indices. Fails if memory runs out.
[[nodiscard]] Result<Figures> mesh_facts(const Surface& surface, const Context& context);

// Adds the figures known only when the mesh is written: file, mesh name, number of vertices in the file, the error if
// it was measured, and the grid if the job has several.
[[nodiscard]] Figures facts_as_written(Figures facts, const std::string& file, const mesh::Mesh& mesh,
                                       const std::optional<Figures>& error, const std::string& grid);

}  // namespace isoextract::convert
