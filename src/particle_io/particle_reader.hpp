// The entry point for reading particles: detects the format of an input, lists its contents, and reads it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "files/file_part.hpp"
#include "particle_io/particle_format.hpp"
#include "points/particle_set.hpp"

namespace isoextract::particle_io {

// `input` is a path, or "-" for standard input. A file may be compressed, or the only one in an archive. All fail with
// - ErrorCode::input if the file is unreadable, damaged, or lacks the wanted frame, attribute or column; the hint lists
//   the existing ones,
// - ErrorCode::usage if options do not fit the format,
// - ErrorCode::unavailable if the format's plug-in is missing or incompatible.

// Returns the format that the input would be read as: by ParticleReadOptions::format, by content, or by extension for
// formats that content does not identify. Returns nothing if the input does not appear to hold particles.
[[nodiscard]] Result<std::optional<ParticleFormatDescription>> detect_particles(const std::string& input,
                                                                                const ParticleReadOptions& options,
                                                                                const Context& context);

// Returns the frames and attributes of a file. Reads only the header if it states the numbers of particles and frames,
// else (CSV, XYZ, LAMMPS, GROMACS, PDB, Houdini since version 12, plug-ins) the file to its end.
//
// A text file that ends within a frame (an interrupted or running simulation) has the frames before it, with a note.
// The functions fail as for a damaged file if the file has no whole frame, or if the options select the incomplete
// frame.
[[nodiscard]] Result<ParticleInfo> list_particles(const std::string& input, const ParticleReadOptions& options,
                                                  const Context& context);

// Returns the input with the bytes that the selected frame depends on. Returns the whole file if the options select no
// frame, if the format cannot tell, or if the file is gzip. In a text file, reads the lines of the frame, and the
// frames before unless an earlier call found where the frame begins.
[[nodiscard]] Result<files::FilePart> find_frame_part(const std::string& input, const ParticleReadOptions& options,
                                                      const Context& context);

// Returns the step and the time of the selected frame, or of the first. In a text file, reads the frame up to its first
// particle, and the frames before unless an earlier call found where the frame begins.
[[nodiscard]] Result<FrameTime> find_frame_time(const std::string& input, const ParticleReadOptions& options,
                                                const Context& context);

struct ParticleFile {
  points::ParticleSet particles;
  std::string format;       // the format's id
  std::string length_unit;  // of the positions; may be empty
  FrameTime time = {};
  std::string creator = {};  // see ScalarField::creator
  Notes notes;               // omissions, assumptions and changes made while reading
};

// Reads one frame, which must be selected if there are several whole ones. Positions are in the file's coordinates and
// can be NaN or infinite as in the file; an empty field of a table is NaN. Reserves memory in the context. Built-in
// formats read the file in blocks, never as a whole.
[[nodiscard]] Result<ParticleFile> read_particles(const std::string& input, const ParticleReadOptions& options,
                                                  const Context& context);

struct DescribedParticles {
  ParticleInfo info;
  std::optional<std::int64_t> frame;  // the frame that was read, if the file has several or one was selected
  ParticleFile file;
};

// Returns the file's description (ParticleInfo) and one frame with all attributes: the selected one, or the first.
// Opens the file only once.
[[nodiscard]] Result<DescribedParticles> describe_particles(const std::string& input,
                                                            const ParticleReadOptions& options, const Context& context);

}  // namespace isoextract::particle_io
