// Makes a plan from the options of `simulate jet`.
#pragma once

#include <string>

#include "base/error.hpp"
#include "cli/options.hpp"
#include "cli/simulate_plan.hpp"
#include "particle_io/particle_writer.hpp"
#include "simulate/particle_jet.hpp"

namespace isoextract::cli {

struct JetPlan {
  simulate::JetOptions jet;
  particle_io::ParticleFileFormat format = particle_io::ParticleFileFormat::ply;
  std::string pattern;    // the value of -o if it works as an input pattern for all frames; else empty
  SequencePlan sequence;  // each step is a frame of the jet
};
// Fails with ErrorCode::usage for too many frames, an unknown format, and as plan_sequence() does.
[[nodiscard]] Result<JetPlan> plan_jet(const JetFlags& flags);

}  // namespace isoextract::cli
