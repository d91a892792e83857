// Plans the options of particles.
#pragma once

#include <optional>
#include <string>

#include "base/error.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::cli {

// `nan` tells what to do with particles whose positions are NaN.
[[nodiscard]] Result<convert::ParticleOptions> plan_particles(const ParticleFlags& flags,
                                                              std::optional<extract::NanPolicy> nan,
                                                              bool has_attributes = false);

// Returns whether vertices get attributes, if only for their colors.
[[nodiscard]] bool has_attributes(const ConvertFlags& flags);

// If no iso value was given, sets IsoChoice::zero(), or for particles the usual value of their method, and returns a
// note about it. Otherwise returns an empty note.
// Opens the file if no option says that it holds particles; the reader later reports errors of the file. Does not read
// standard input, which would have to be buffered: it counts as particles if its given format is a particle format.
[[nodiscard]] Result<std::string> set_default_iso(ConvertFlags& flags, const std::string& input,
                                                  const Context& context);

}  // namespace isoextract::cli
