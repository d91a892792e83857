#include "convert/verification.hpp"

#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "measure/stability.hpp"

namespace isoextract::convert {
namespace {

// What both kinds of verification count; each pair is of the first and of the second mesh.
Json counts(const measure::TriangleDifference& triangles, const std::array<std::uint64_t, 2>& vertices,
            const std::array<std::uint64_t, 2>& vertices_only, const std::vector<std::string>& differences) {
  return {{"passed", differences.empty()},    {"differences", differences}, {"triangles", triangles.total},
          {"triangles_only", triangles.only}, {"vertices", vertices},       {"vertices_only", vertices_only}};
}

}  // namespace

Json json_of(const VerificationRecord& record) {
  const measure::ExtractionComparison& found = record.comparison;
  Json json{{"iso", record.iso}, {"backends", record.backends}};
  if (!record.not_applicable.empty()) {
    json["passed"] = nullptr;
    json["not_applicable"] = record.not_applicable;
    json["time"] = json_of(record.time);
    return json;
  }
  json.update(counts(found.triangles, found.vertices, found.vertices_only, record.differences));
  json["ulps"] = found.ulps;
  json["ulps_allowed"] = measure::kStabilityUlps;
  json["degrees"] = found.normals_compared ? Json(found.degrees) : Json(nullptr);
  json["degrees_allowed"] = measure::kNormalDegrees;
  json["time"] = json_of(record.time);
  return json;
}

Json json_of(const measure::MeshMatch& match, const std::vector<std::string>& differences) {
  Json json = counts(match.triangles, match.vertices, match.vertices_only, differences);
  json["distance"] = match.matched > 0 ? json_of(match.distance) : Json(nullptr);
  json["distance_allowed"] = json_of(match.allowed);
  return json;
}

std::string why_not_comparable(const extract::MethodInfo& method, const extract::Extractor& first,
                               const extract::Extractor& second) {
  for (const extract::Extractor* backend : {&first, &second}) {
    if (!backend->has(method.method)) return fmt::format("{} does not have {}", backend->name(), method.title);
  }
  return extract::why_no_edges(method);
}

Result<VerificationRecord> compare_backends(const field::ScalarField& field, const extract::ExtractOptions& options,
                                            const extract::MethodInfo& method, const mesh::Mesh& mesh,
                                            const extract::Extractor& first, extract::Extractor& second,
                                            const Context& context) {
  const Stopwatch watch;
  VerificationRecord record;
  record.iso = options.iso;
  record.backends = {std::string(first.name()), std::string(second.name())};
  record.not_applicable = why_not_comparable(method, first, second);
  if (!record.not_applicable.empty()) return record;
  auto other = TRY(second.extract(field, options, context));
  auto comparison = TRY(measure::compare_extractions(mesh, other.mesh, context));
  record.differences = measure::differences(comparison, {record.backends[0], record.backends[1]});
  record.comparison = comparison;
  record.time = watch.elapsed();
  return record;
}

Result<void> check_verification(const std::string& label, const VerificationRecord& record) {
  if (record.differences.empty()) return {};
  return fail(ErrorKind::verification,
              fmt::format("{} iso {}: {} and {} differ: {}", label, record.iso, record.backends[0], record.backends[1],
                          fmt::join(record.differences, "; ")),
              "this is a defect of one of them; please report it");
}

}  // namespace isoextract::convert
