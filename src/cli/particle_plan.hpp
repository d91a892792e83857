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
                                                              std::optional<extract::NanPolicy> nan);

// Formats that have no place for attributes are refused where some are asked for.
[[nodiscard]] Result<void> check_attributes(const ParticleFlags& flags, const meshes::MeshFormatInfo& format);

struct MethodIso {
  double iso = 0;
  std::string note;  // that it was taken
};

// The iso value of particles where none was given: that of their method. Nothing where `source` is a volume, or cannot
// be read; who opens it tells that. Looks into the file where no option says that it is of particles, but not into
// standard input, which would have to be kept.
[[nodiscard]] std::optional<MethodIso> iso_of_method(const convert::SourceOptions& source);

}  // namespace isoextract::cli
