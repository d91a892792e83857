// Inputs made of particles: detection, read options, and the options to make a field from the particles.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "base/stopwatch.hpp"
#include "convert/conversion_job.hpp"
#include "field/scalar_field.hpp"
#include "files/file_part.hpp"
#include "particle_io/particle_reader.hpp"
#include "points/particle_field.hpp"

namespace isoextract::convert {

// Returns whether the input is read as particles: because the options say so, else by its content, or by its name for
// formats that only the name identifies. A file that could be both is a volume, with two exceptions: files that hold
// only points, and point grids that the options choose by name.
//
// Fails with ErrorCode::usage if particles are expected and the input is a volume, or if the input is particles and
// options for volumes are set. Fails if the input cannot be read.
[[nodiscard]] Result<bool> is_particles(const SourceOptions& options, const Context& context);

// Returns the files of the input and, for volumes, the files that attributes are read from.
[[nodiscard]] Result<std::vector<std::filesystem::path>> list_source_files(const SourceOptions& options,
                                                                           const Context& context);
// Returns the same files with the bytes of each that the selected volume or frame depends on; a part without ranges is
// its whole file.
[[nodiscard]] Result<std::vector<files::FilePart>> list_source_parts(const SourceOptions& options,
                                                                     const Context& context);
// The volumes or the particle frames of an input.
struct FrameList {
  std::uint64_t count = 0;
  std::vector<particle_io::FrameTime> times = {};  // of each frame; empty for inputs without steps and times
  Notes notes = {};
};
[[nodiscard]] Result<FrameList> list_frames(const SourceOptions& options, const Context& context);
// Returns the step and the time of the selected frame, or of the first; unset for volumes.
[[nodiscard]] Result<particle_io::FrameTime> find_frame_time(const SourceOptions& options, const Context& context);

// Returns the read options. With `allow_missing` no attribute has to exist; optional attributes never have to.
[[nodiscard]] particle_io::ParticleReadOptions particle_read_options(const SourceOptions& options,
                                                                     bool allow_missing = false);
// Returns the options to make a field, with the margin that filters and blurs need. `only_iso`: FieldOptions::tile_iso.
[[nodiscard]] points::FieldOptions field_options(const SourceOptions& options, std::optional<double> only_iso);

// Particles kept in memory for the vertex attributes.
struct ParticleAttributes {
  std::shared_ptr<const points::ParticleSet> particles;
  std::vector<AttributeChoice> choices;
  std::vector<std::size_t> attributes;  // indices into the particles' attributes, one for each choice
  double radius = 0;                    // in world units
  double smoothing_length = 0;          // in radii
};

// Particles kept in memory for the weights of edit::SmoothMethod::weighted.
struct NeighborCounts {
  std::shared_ptr<const points::ParticleSet> particles;
  std::size_t attribute = 0;    // index of the counts (points::add_neighbor_counts())
  double radius = 0;            // in world units
  double smoothing_length = 0;  // in radii
};

// The chosen attributes that exist and those that do not.
struct FoundAttributes {
  std::vector<AttributeChoice> choices;
  std::vector<std::size_t> attributes;  // indices into the particles' attributes, one for each choice
  std::vector<MissingAttribute> missing;
};

// Finds the chosen attributes. Fails with ErrorCode::input if an attribute has more components than a vertex can carry,
// or does not exist and is neither optional nor covered by `allow_missing`. Fails with ErrorCode::usage if a choice
// has settings for volumes.
[[nodiscard]] Result<FoundAttributes> find_attributes(const points::ParticleSet& particles,
                                                      const std::vector<AttributeChoice>& choices, bool allow_missing);

}  // namespace isoextract::convert
