// Reads points of Houdini's geometry files since version 12: arrays of names and values in binary JSON.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/note.hpp"
#include "files/file_version.hpp"
#include "particle_io/detail/particle_columns.hpp"

namespace isoextract::particle_io {

// ScalarField::creator for files that do not name Houdini as their program, as other programs write these formats too.
inline constexpr const char* kHoudiniFormat = "Houdini's format";

struct HoudiniAttribute {
  std::string name;
  std::string type;  // "numeric", "string", ...
  std::uint64_t size = 0;
  std::string storage;
  std::string type_info;  // "vector", "normal", "color", "point", ...; may be empty

  friend bool operator==(const HoudiniAttribute&, const HoudiniAttribute&) = default;
};

struct HoudiniFile {
  std::uint64_t points = 0;
  std::uint64_t primitives = 0;
  std::string software;                      // program that wrote the file: "Houdini 18.0.499"; may be empty
  std::vector<HoudiniAttribute> attributes;  // of points
  Notes notes;
  files::FileVersion version;
};

// All functions throw InvalidParticleFile and Refused.

// Reads the whole file for its counts and attributes, without the attributes' values.
[[nodiscard]] HoudiniFile scan_houdini(const files::InputFile& file);

// Describes a file, for ParticleFormat::info().
[[nodiscard]] ParticleInfo houdini_info(const files::InputFile& file, const ParticleReadOptions& options);
// Reads a file in a second pass, for ParticleFormat::read(). Fails if the pass finds other attributes than `surveyed`.
[[nodiscard]] ParticleFile read_houdini(const files::InputFile& file, const HoudiniFile& surveyed,
                                        const ParticleReadOptions& options);

}  // namespace isoextract::particle_io
