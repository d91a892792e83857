// The options of particles, as values of a job.
#pragma once

#include <optional>
#include <string>

#include "base/error.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::cli {

// `nan` says what becomes of particles at places that are no numbers.
[[nodiscard]] Result<convert::ParticleOptions> plan_particles(const ParticleFlags& flags,
                                                              std::optional<extract::NanPolicy> nan,
                                                              bool has_attributes = false);

// Whether vertices are to get attributes, if only for their colours.
[[nodiscard]] bool has_attributes(const ConvertFlags& flags);

// Where no iso value was given: gives the flags IsoChoice::zero(), or where `input` is of particles the value of their
// method, and returns a note of that. Else the note is empty; who opens the input tells what is wrong with it. Looks
// into the file where no option says that it is of particles, but not into standard input, which would have to be kept:
// that is of particles where the format that it is read as is one of them.
[[nodiscard]] Result<std::string> take_usual_iso(ConvertFlags& flags, const std::string& input, const Context& context);

}  // namespace isoextract::cli
