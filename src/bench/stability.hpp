// Runs a stability case with a method on a backend, without and with a cap.
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
  StabilityFindings findings;               // both meshes together
  double voxels_allowed = 0;                // StabilityScene::voxels
  std::vector<std::string> failures;        // empty if the case passes
  std::vector<std::string> not_applicable;  // unchecked claims and the reason, sentences without full stop
};

// Checks that all vertices are finite, inside their own grid edge and near the crossing. Checks that triangles have an
// area and no duplicates, and that the mesh is oriented and manifold. Unless NanPolicy::hole leaves holes, the mesh
// must be closed with a cap, and also without a cap if StabilityScene::closed is set. Methods with
// MethodTraits::always_closed must always close the mesh; they run with NanPolicy::outside in place of NanPolicy::hole.
// A surface must exist exactly where the scene expects one, and a refusal must be ErrorCode::input. Edges and crossings
// are checked only if the method's traits claim them. Other errors of the extraction are failures of the case.
[[nodiscard]] StabilityRow run_stability_case(const StabilityCase& test, const extract::MethodInfo& method,
                                              extract::Extractor& extractor, const Context& context);

}  // namespace isoextract::bench
