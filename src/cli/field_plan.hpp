// Plans outputs that hold the field itself instead of its surfaces.
#pragma once

#include <string>
#include <string_view>

#include "base/error.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

inline constexpr std::string_view kFieldFormat = "vdb";  // also the extension, without its dot

// Decides by --format, or else by the extension of -o.
[[nodiscard]] bool writes_field(const ConvertFlags& flags);

// Refuses options for surfaces and meshes if the output is a field, and --half if it is a mesh.
[[nodiscard]] Result<void> check_field_options(const ConvertFlags& flags);

// Refuses filters, which need a level set, if the particle method does not make one.
[[nodiscard]] Result<void> check_filters(const SurfaceFlags& surface, const ParticleFlags& particles);

}  // namespace isoextract::cli
