// What reports tell of a mesh that was written: size, topology, components.
#pragma once

#include <optional>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/stage_report.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

// Fails where the memory to look at the mesh is not there.
[[nodiscard]] Result<Figures> mesh_facts(const Surface& surface, const Context& context);

// The same with what was found out since: the file, the name and the number of vertices of the mesh as it is written,
// its error where it was measured, and its grid where the job has several.
[[nodiscard]] Figures facts_as_written(Figures facts, const std::string& file, const mesh::Mesh& mesh,
                                       const std::optional<Figures>& error, const std::string& grid);

}  // namespace isoextract::convert
