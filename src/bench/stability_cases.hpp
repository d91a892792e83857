// Fields that break extractors which compute in float32 or trust their samples: the cases of `isoextract stability`.
#pragma once

#include <span>
#include <string_view>

#include "extract/extractor.hpp"

namespace isoextract::bench {

enum class StabilityOutcome {
  surface,   // a surface
  cap_only,  // all samples are inside: only the cap
  nothing,   // no sample is inside
  // The samples span no cell: ErrorCode::input, but a surface from methods that are always_closed.
  refusal,
};

struct StabilityScene {
  field::ScalarField field;         // dense
  extract::ExtractOptions options;  // iso value, NaN policy, placement
  StabilityOutcome outcome = StabilityOutcome::surface;
  bool closed = true;  // closed even without a cap
  // Allowed StabilityFindings::voxels, a vertex's distance from its crossing: the margin at edge ends plus rounding.
  double voxels = 2e-5;
};

struct StabilityCase {
  std::string_view name;
  std::string_view extreme;  // the extreme property of the case
  std::string_view plain;    // the result of plain float32 crossings and positions
  bool float32_fails;        // `plain` fails the checks, as a unit test shows
  StabilityScene (*make)();
};

[[nodiscard]] std::span<const StabilityCase> stability_cases();

}  // namespace isoextract::bench
