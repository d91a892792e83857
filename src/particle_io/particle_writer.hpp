// The entry point for writing particles: a set as one file, atomically.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "points/particle_set.hpp"

namespace isoextract::particle_io {

// The formats. Files have positions as float64 and attributes as float32, so that read_particles() returns the same
// numbers. "Words" are points::ParticleWords: one text per particle, such as its element.
enum class ParticleFileFormat {
  ply,   // binary: x, y, z; NAME, or NAME_x, NAME_y, NAME_z for three components, or NAME_0, NAME_1, ...
  npy,   // structured array: position (3), and each attribute with its components
  xyz,   // extended XYZ, text: words, pos, each attribute, and the box
  bgeo,  // Houdini geometry since version 12, binary: P, each attribute with its kind, and words
  vtu,   // VTK unstructured grid, appended raw: a vertex cell per particle
};
constexpr auto words_of(ParticleFileFormat /*type*/) {
  return std::array{Word{ParticleFileFormat::ply, "ply"}, Word{ParticleFileFormat::npy, "npy"},
                    Word{ParticleFileFormat::xyz, "xyz"}, Word{ParticleFileFormat::bgeo, "bgeo"},
                    Word{ParticleFileFormat::vtu, "vtu"}};
}

// stores_words() returns whether files of the format can hold words, and stores_box() whether they can hold the
// simulation box. Where they return false, write_particles() omits the words or the box. fit_to_file() removes the
// words that a file cannot hold for other reasons.
[[nodiscard]] constexpr bool stores_words(ParticleFileFormat format) {
  return format == ParticleFileFormat::xyz || format == ParticleFileFormat::bgeo;
}
[[nodiscard]] constexpr bool stores_box(ParticleFileFormat format) { return format == ParticleFileFormat::xyz; }
// Returns whether y is the up axis of the program that the format belongs to; the other formats have no up axis.
// write_particles() turns nothing.
[[nodiscard]] constexpr bool is_y_up(ParticleFileFormat format) { return format == ParticleFileFormat::bgeo; }

// Changes particles so that write_particles() can write them in the format. Renames attributes and words whose names
// write_particles() refuses. Removes words if stores_words() is false, if they are ParticleWords::too_many, and for XYZ
// if one of them is empty or has spaces. Returns a note about each change.
[[nodiscard]] Notes fit_to_file(points::ParticleSet& particles, ParticleFileFormat format);

// Returns the format for a file's extension, ignoring case.
[[nodiscard]] std::optional<ParticleFileFormat> particle_file_format_by_path(const std::filesystem::path& path);

// Writes the file and returns its number of bytes; the bytes do not depend on the number of threads. "-" is standard
// output. Fails with ErrorCode::output if the file cannot be written, if there are more than 100 attributes, if
// words are ParticleWords::too_many, or if the name of an attribute or of words
// - has characters other than A to Z, a to z, digits and underscores,
// - is empty or longer than 40 characters,
// - equals another name or one of x, y, z, p, pos, points and position, ignoring case.
[[nodiscard]] Result<std::uint64_t> write_particles(const std::filesystem::path& path,
                                                    const points::ParticleSet& particles, ParticleFileFormat format);

}  // namespace isoextract::particle_io
