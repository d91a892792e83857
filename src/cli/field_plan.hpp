// Checks the options of outputs that hold the field itself instead of its surfaces, and the filters.
#pragma once

#include <array>
#include <optional>

#include "base/error.hpp"
#include "cli/options.hpp"
#include "volume_io/volume_writer.hpp"

namespace isoextract::cli {

// Formats of the field itself; their words are also the extensions, without the dot.
inline constexpr std::array kFieldFormats{volume_io::VolumeFileFormat::vdb, volume_io::VolumeFileFormat::nrrd,
                                          volume_io::VolumeFileFormat::npy, volume_io::VolumeFileFormat::vti};

// Returns the format if the output is the field itself (by --format, or else by the extension of -o), else nullopt.
[[nodiscard]] std::optional<volume_io::VolumeFileFormat> field_format(const ConvertFlags& flags);
[[nodiscard]] inline bool writes_field(const ConvertFlags& flags) { return field_format(flags).has_value(); }

// Fails with ErrorCode::usage if the output is the field and an option needs a surface (About::surface, --nan hole,
// {iso} in -o). Fails with the same code if --half is given for another output or a format without 16-bit floats.
[[nodiscard]] Result<void> check_field_options(const ConvertFlags& flags);

// Fails with ErrorCode::usage if --filter, which needs a level set, is given with a --particles method that makes a
// density.
[[nodiscard]] Result<void> check_filters(const SurfaceFlags& surface, const ParticleFlags& particles);

}  // namespace isoextract::cli
