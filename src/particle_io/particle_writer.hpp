// The door for particles that are written: a set as one file, whole or not at all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "base/error.hpp"
#include "base/words.hpp"
#include "points/particle_set.hpp"

namespace isoextract::particle_io {

// Positions are written as float64 and attributes as float32, so that read_particles() gives the same numbers again.
enum class ParticleFileFormat {
  ply,  // binary: x, y, z; NAME, or NAME_x, NAME_y, NAME_z of three components, or NAME_0, NAME_1, ...
  npy,  // a structured array: position (3), and each attribute with its components
  xyz,  // extended XYZ, text: pos, and each attribute
};
constexpr auto words_of(ParticleFileFormat /*type*/) {
  return std::array{Word{ParticleFileFormat::ply, "ply"}, Word{ParticleFileFormat::npy, "npy"},
                    Word{ParticleFileFormat::xyz, "xyz"}};
}

// By the extension of a name, upper case or lower.
[[nodiscard]] std::optional<ParticleFileFormat> particle_file_format_by_path(const std::filesystem::path& path);

// Gives the number of bytes; they do not depend on the number of threads. "-" is standard output. Fails with
// ErrorCode::output where the file cannot be written, and for attributes whose names are anything else than A to Z, a
// to z, digits and underscores, more than 40 of those, that of another one or that of the position, and for more than
// 100 attributes.
[[nodiscard]] Result<std::uint64_t> write_particles(const std::filesystem::path& path,
                                                    const points::ParticleSet& particles, ParticleFileFormat format);

}  // namespace isoextract::particle_io
