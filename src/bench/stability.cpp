#include "bench/stability.hpp"

#include <utility>

#include <fmt/format.h>

#include "accuracy/extraction_comparison.hpp"

namespace isoextract::bench {
namespace {

bool expects_triangles(StabilityOutcome outcome, bool cap, bool always_closed) {
  switch (outcome) {
    case StabilityOutcome::surface: return true;
    case StabilityOutcome::cap_only: return cap || always_closed;
    case StabilityOutcome::nothing: return false;
    case StabilityOutcome::refusal: return always_closed;
  }
  return false;
}

void run_once(const StabilityScene& scene, const extract::ExtractOptions& options, const extract::MethodTraits& traits,
              extract::Extractor& extractor, const Context& context, StabilityRow& row) {
  const auto add = [&](std::string_view what) {
    row.failures.push_back(fmt::format("{}{}", options.cap ? "with a cap: " : "", what));
  };
  const auto extraction = extractor.extract(scene.field, options, context);
  if (scene.outcome == StabilityOutcome::refusal && !traits.always_closed) {
    if (extraction || extraction.error().code != ErrorCode::input)
      add("the extraction accepted samples that it must reject");
    return;
  }
  if (!extraction) return add(extraction.error().message);
  const mesh::Mesh& mesh = extraction->mesh;
  const bool expected = expects_triangles(scene.outcome, options.cap, traits.always_closed);
  if (mesh.triangles.empty() == expected) add(expected ? "no surface, expected one" : "a surface, expected none");
  const StabilityFindings findings = check_stability(mesh, scene.field, options, traits);
  const bool must_be_closed =
      traits.always_closed || (options.nan != extract::NanPolicy::hole && (options.cap || scene.closed));
  for (const std::string& failure : failures(findings, must_be_closed, accuracy::kStabilityUlps, scene.voxels))
    add(failure);
  row.findings.add(findings);
}

}  // namespace

StabilityRow run_stability_case(const StabilityCase& test, const extract::MethodInfo& method,
                                extract::Extractor& extractor, const Context& context) {
  const StabilityScene scene = test.make();
  StabilityRow row;
  row.name = test.name;
  row.method = method.method;
  row.backend = extractor.name();
  row.voxels_allowed = scene.voxels;
  row.findings = empty_findings(method.traits);
  for (std::string reason : {extract::why_no_edge_keys(method), extract::why_no_crossings(method),
                             extract::why_no_gradient_normals(method)}) {
    if (!reason.empty()) row.not_applicable.push_back(std::move(reason));
  }
  if (scene.options.nan == extract::NanPolicy::hole && method.traits.always_closed) {
    row.not_applicable.push_back(extract::why_no_holes(method));
  }
  for (const bool cap : {false, true}) {
    extract::ExtractOptions options = scene.options;
    options.method = method.method;
    options.smooth_normals = method.traits.gradient_normals;
    options.cap = cap;
    if (options.nan == extract::NanPolicy::hole && method.traits.always_closed) {
      options.nan = extract::NanPolicy::outside;
    }
    run_once(scene, options, method.traits, extractor, context, row);
  }
  return row;
}

}  // namespace isoextract::bench
