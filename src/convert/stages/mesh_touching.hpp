// Sheets of a surface that touch, in files whose readers weld vertices by position.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/stage_report.hpp"
#include "convert/stages/surface_stages.hpp"

namespace isoextract::convert {

// Returns the positions as a format of float32 world coordinates stores them.
[[nodiscard]] Buffer<glm::vec3> written_positions(const mesh::Mesh& mesh);

// Returns the topology of the surface after a reader of the job's file has welded vertices by their float32 positions.
// Returns nullopt if readers of this format keep the vertices apart, or if all vertices have different positions
// already. Fails with ErrorCode::out_of_memory.
[[nodiscard]] Result<std::optional<mesh::Topology>> topology_as_read(const Surface& surface, const ConversionJob& job,
                                                                     const Context& context);

// Returns a note with the numbers of vertices that touched and that moved apart, the largest distance of a move, and
// the largest change of a volume; nullopt if no sheets touched. `reports` are those of one conversion.
[[nodiscard]] std::optional<std::string> note_of_touching(std::span<const StageReport> reports);

}  // namespace isoextract::convert
