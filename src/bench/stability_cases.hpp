// Fields that break extractors which compute in float32 or trust their samples: the cases of `isoextract stability`.
#pragma once

#include <span>
#include <string_view>

#include "extract/extractor.hpp"

namespace isoextract::bench {

enum class StabilityOutcome {
  surface,   // there is one
  cap_only,  // all is inside: only a cap
  nothing,   // no sample is inside
  refusal,   // ErrorCode::input: the samples span no cell; of methods that always close the surface there is one
};

struct StabilityScene {
  field::ScalarField field;         // dense
  extract::ExtractOptions options;  // iso value, what NaN means, placement
  StabilityOutcome outcome = StabilityOutcome::surface;
  bool closed = true;    // also without a cap
  double voxels = 2e-5;  // how far a vertex may be from its crossing: the margin at the ends of edges, and rounding
};

struct StabilityCase {
  std::string_view name;
  std::string_view extreme;  // what is extreme about it
  std::string_view plain;    // what crossings and positions in plain float32 make of it
  bool plain_fails;          // a test shows it
  StabilityScene (*make)();
};

[[nodiscard]] std::span<const StabilityCase> stability_cases();

}  // namespace isoextract::bench
