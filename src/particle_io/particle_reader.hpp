// The one door to files of particles: which format an input is, what is in it, and reading it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "particle_io/particle_format.hpp"
#include "points/particle_set.hpp"

namespace isoextract::particle_io {

// `input` is a path, or "-" for standard input. Files may be gzip. Failures are ErrorCode::input (unreadable, not what
// the format asks for, no such frame, attribute or column; the hint lists what there is), ErrorCode::usage (options
// that do not go with the format) or ErrorCode::unavailable (the plug-in of the format is missing or does not fit).

// The format that an input would be read as: by ParticleReadOptions::format, by its content, or by its extension where
// content tells nothing of a format. Nothing where it is none of particles, as far as that shows.
[[nodiscard]] Result<std::optional<ParticleFormatDescription>> detect_particles(const std::string& input,
                                                                                const ParticleReadOptions& options,
                                                                                const Context& context);

// Reads headers, and text files from end to end where they do not say how much is in them.
[[nodiscard]] Result<ParticleInfo> particle_info(const std::string& input, const ParticleReadOptions& options,
                                                 const Context& context);

struct ParticleFile {
  points::ParticleSet particles;
  std::string format;              // the id of one
  std::string length_unit;         // of the positions, where the file says so
  std::string time_step = {};      // the number that the file gives this frame; empty where it has none
  std::string creator = {};        // as ScalarField::creator
  std::vector<std::string> notes;  // what was left out, assumed, or taken otherwise than the file has it
};

// Reads one frame; a file with several needs a choice. Positions are in the file's own coordinates, and may be NaN or
// infinite where the file has that; a field that a table leaves empty is NaN. Its memory is reserved in the context,
// and blocks of the file are on the way: never the file as a whole.
[[nodiscard]] Result<ParticleFile> read_particles(const std::string& input, const ParticleReadOptions& options,
                                                  const Context& context);

struct DescribedParticles {
  ParticleInfo info;
  std::optional<std::int64_t> frame;  // that was read, where the file has several or one was asked for
  ParticleFile file;
};

// Both at once, with one opening of the file: what is in it, and a frame with all attributes. It is the first one where
// the options choose none.
[[nodiscard]] Result<DescribedParticles> describe_particles(const std::string& input,
                                                            const ParticleReadOptions& options, const Context& context);

}  // namespace isoextract::particle_io
