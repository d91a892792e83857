// Checks the options of outputs that hold the field itself instead of its surfaces, and the filters.
#pragma once

#include <string>
#include <string_view>

#include "base/error.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

inline constexpr std::string_view kFieldFormat = "vdb";  // also the extension, without its dot

// Returns whether the output is the field: by --format, or else by the extension of -o.
[[nodiscard]] bool writes_field(const ConvertFlags& flags);

// Fails with ErrorCode::usage if the output is the field and an option needs a surface (About::surface, --nan hole,
// {iso} in -o), or if it is a mesh or picture and --half is given.
[[nodiscard]] Result<void> check_field_options(const ConvertFlags& flags);

// Fails with ErrorCode::usage if --filter, which needs a level set, is given with a --particles method that makes
// none.
[[nodiscard]] Result<void> check_filters(const SurfaceFlags& surface, const ParticleFlags& particles);

}  // namespace isoextract::cli
