// The stage that writes the chosen particles instead of a surface.
#pragma once

#include <optional>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::convert {

// Reads the particles with all attributes, applies condition, stride, radii of elements, box and region, and writes the
// remaining particles to one output of `job`, completely or not at all. If no particle remains, calls leave_out_empty()
// and returns nullopt, unless the job writes empty files. Positions are those of the input, or unwrapped ones.
//
// Reports how many particles were left out, and notes facts that the file lacks: attributes of words, the box, the unit
// of length, and names that the format does not allow. Fails with ErrorCode::usage if the input is a volume, and as
// particle_io::read_particles(), keep_chosen(), apply_box_options() and particle_io::write_particles() do.
[[nodiscard]] Result<std::optional<mesh_io::WrittenFile>> write_particle_file(const ConversionJob& job,
                                                                              const OutputFileJob& output,
                                                                              const Context& context, Events& events);

// Reads and chooses the particles as write_particle_file() does, and fails as it does. Returns the peak reservation.
[[nodiscard]] Result<std::uint64_t> particle_file_memory(const ConversionJob& job, const Context& context);

}  // namespace isoextract::convert
