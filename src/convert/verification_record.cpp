#include "convert/verification_record.hpp"

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
  json["distance"] = json_of(match.distance);
  json["distance_allowed"] = json_of(match.allowed);
  return json;
}

}  // namespace isoextract::convert
