#include "convert/verification.hpp"

#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "convert/json_values.hpp"

namespace isoextract::convert {
namespace {

// Returns the counts that both kinds of verification have. Pairs are of the first and the second mesh.
Figures counts(const accuracy::TriangleDifference& triangles, const std::array<std::uint64_t, 2>& vertices,
               const std::array<std::uint64_t, 2>& vertices_only, const std::vector<std::string>& differences) {
  return {{Key::passed, differences.empty()}, {Key::differences, Value::List(differences.begin(), differences.end())},
          {Key::triangles, triangles.total},  {Key::triangles_only, triangles.only},
          {Key::vertices, vertices},          {Key::vertices_only, vertices_only}};
}

Figures figures_of(const VerificationRecord& record) {
  const accuracy::ExtractionComparison& found = record.comparison;
  Figures figures{{Key::backends, record.backends}};
  if (!record.not_applicable.empty()) {
    figures.insert(figures.end(), {{Key::passed, Value()}, {Key::not_applicable, record.not_applicable}});
    return figures;
  }
  const Figures counted = counts(found.triangles, found.vertices, found.vertices_only, record.differences);
  figures.insert(figures.end(), counted.begin(), counted.end());
  figures.insert(figures.end(), {{Key::ulps, found.ulps},
                                 {Key::ulps_allowed, accuracy::kStabilityUlps},
                                 {Key::degrees, found.normals_compared ? Value(found.degrees) : Value()},
                                 {Key::degrees_allowed, accuracy::kNormalDegrees}});
  return figures;
}

// Returns "verified at iso 0.5: gpu gives the same 12 triangles and 8 vertices as cpu, at most 0.5 ulps apart; 0.01 s".
std::string line_of(const VerificationRecord& record) {
  if (!record.not_applicable.empty()) {
    return fmt::format("not verified at iso {}: not applicable: {}", record.iso, record.not_applicable);
  }
  const accuracy::ExtractionComparison& found = record.comparison;
  std::string text = fmt::format(
      "verified at iso {}: {} gives the same {} triangles and {} vertices as {}, at most "
      "{:.3g} ulps apart",
      record.iso, record.backends[1], found.triangles.total[1], found.vertices[1], record.backends[0], found.ulps);
  if (found.normals_compared) text += fmt::format(", normals at most {:.3g} degrees", found.degrees);
  return text + fmt::format("; {:.2f} s", record.time.wall_seconds);
}

}  // namespace

StageReport report_of(const VerificationRecord& record, const std::string& label) {
  StageReport report(StageName::verify, fmt::format("{} iso {}", label, record.iso), label, record.iso);
  report.add_timed(figures_of(record), record.time);
  if (record.not_applicable.empty()) report.did = "compared backends";
  if (auto same = check_verification(label, record); !same) {
    report.error = std::move(same.error());
  } else {
    report.lines.push_back({line_of(record)});
  }
  return report;
}

Json json_of(const accuracy::MeshMatch& match, const std::vector<std::string>& differences) {
  Json json = json_of(counts(match.triangles, match.vertices, match.vertices_only, differences));
  json["distance"] = match.matched > 0 ? convert::json_of(match.distance) : Json(nullptr);
  json["distance_allowed"] = convert::json_of(match.allowed);
  return json;
}

std::string why_not_comparable(const extract::MethodInfo& method, const extract::Extractor& first,
                               const extract::Extractor& second) {
  for (const extract::Extractor* backend : {&first, &second}) {
    if (!backend->has(method.method)) return fmt::format("{} does not have {}", backend->name(), method.title);
  }
  return extract::why_no_edge_keys(method);
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
  auto comparison = TRY(accuracy::compare_extractions(mesh, other.mesh, context));
  record.differences = accuracy::differences(comparison, {record.backends[0], record.backends[1]});
  record.comparison = comparison;
  record.time = watch.elapsed();
  return record;
}

Result<void> check_verification(const std::string& label, const VerificationRecord& record) {
  if (record.differences.empty()) return {};
  return fail(ErrorCode::verification,
              fmt::format("{} iso {}: {} and {} differ: {}", label, record.iso, record.backends[0], record.backends[1],
                          fmt::join(record.differences, "; ")),
              "one of the two backends is wrong; please report this");
}

}  // namespace isoextract::convert
