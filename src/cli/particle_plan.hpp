// Plans the options of particles.
#pragma once

#include <optional>
#include <string>

#include "base/error.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::cli {

// Plans the particle options. Particles at NaN or infinite positions are skipped if `nan` is NanPolicy::outside, else
// an error. Fails with ErrorCode::usage for options that have no effect or contradict each other. With
// `has_attributes` (vertices get attributes), --smoothing-length has an effect for every method.
[[nodiscard]] Result<convert::ParticleOptions> plan_particles(const ParticleFlags& flags,
                                                              std::optional<extract::NanPolicy> nan,
                                                              bool has_attributes = false);

// Returns whether vertices get attributes, by --attribute or only for the colors of --color-by.
[[nodiscard]] bool has_attributes(const ConvertFlags& flags);

// Sets the iso value if none was given: for particles the default of their method, for other inputs
// IsoChoice::zero_by_default(). Returns a note about the default of a method, else an empty text.
//
// Opens `input` if no option says that it holds particles. Fails with ErrorCode::usage for options that contradict
// each other or the file; leaves other errors of the file to the reader. Does not read standard input, because that
// would need a buffer: standard input counts as particles if --input-format is a particle format.
[[nodiscard]] Result<std::string> set_default_iso(ConvertFlags& flags, const std::string& input,
                                                  const Context& context);

}  // namespace isoextract::cli
