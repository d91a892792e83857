// Outputs that hold the field itself, in place of surfaces of it.
#pragma once

#include <string>
#include <string_view>

#include "base/error.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

inline constexpr std::string_view kFieldFormat = "vdb";  // also the extension, without its dot

// By --format, and else by the name after -o.
[[nodiscard]] bool writes_field(const ConvertFlags& flags);

// Options that are about surfaces and meshes are refused where a field is written, and --half where a mesh is.
[[nodiscard]] Result<void> check_field_options(const ConvertFlags& flags);

// Filters need a level set, and the method of particles may be known to make none.
[[nodiscard]] Result<void> check_filters(const SurfaceFlags& surface, const ParticleFlags& particles);

}  // namespace isoextract::cli
