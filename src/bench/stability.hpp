// Runs a stability case on a method and a backend, without and with a cap.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "bench/stability_cases.hpp"
#include "bench/stability_checks.hpp"

namespace isoextract::bench {

struct StabilityRow {
  std::string_view name;
  extract::Method method = extract::Method::mc;
  std::string backend;
  StabilityFindings findings;  // of both meshes together
  double voxels_allowed = 0;
  std::vector<std::string> failures;        // empty if the case passes
  std::vector<std::string> not_applicable;  // what was not checked, and why; sentences without their full stop
};

// What must hold: vertices are finite, each strictly within its own edge of the grid and near the crossing; triangles
// have an area and are there once; the mesh is oriented and manifold, closed with a cap (unless holes are asked for),
// and without one where the scene says so; there is a surface exactly where there should be one. Of vertices on edges
// and of crossings that holds where the method's traits say so, and is not checked elsewhere.
[[nodiscard]] StabilityRow run_stability_case(const StabilityCase& test, const extract::MethodInfo& method,
                                              extract::Extractor& extractor, const Context& context);

}  // namespace isoextract::bench
