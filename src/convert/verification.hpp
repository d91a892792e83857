// The stage that compares one backend with another; what a verification found, and its JSON: the report's section
// "verification", and what `verify --json` prints.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "accuracy/extraction_comparison.hpp"
#include "accuracy/mesh_match.hpp"
#include "base/context.hpp"
#include "base/stopwatch.hpp"
#include "convert/json_type.hpp"
#include "convert/stage_report.hpp"
#include "extract/extractor.hpp"

namespace isoextract::convert {

// Of one surface, extracted by two backends.
struct VerificationRecord {
  double iso = 0;
  std::array<std::string, 2> backends;  // the one whose mesh is written comes first
  std::string not_applicable;           // why nothing was compared, as a sentence without its full stop; else empty
  accuracy::ExtractionComparison comparison;
  std::vector<std::string> differences;  // none if it passed
  StageTime time;                        // of the second extraction and the comparison
};

// Why the surfaces of a method by `first` and `second` cannot be compared, likewise: a backend does not have it, or
// its vertices have no edge keys.
[[nodiscard]] std::string why_not_comparable(const extract::MethodInfo& method, const extract::Extractor& first,
                                             const extract::Extractor& second);

// Of a surface of the field that `label` names.
[[nodiscard]] StageReport report_of(const VerificationRecord& record, const std::string& label);

// Extracts with `second` what `first` made `mesh` of, and compares, where that can be. `options` are those of `mesh`:
// by `method`, and with edge keys where it has them. Fails as the extraction and the comparison do; what differs is no
// failure here, nor is what cannot be compared.
[[nodiscard]] Result<VerificationRecord> compare_backends(const field::ScalarField& field,
                                                          const extract::ExtractOptions& options,
                                                          const extract::MethodInfo& method, const mesh::Mesh& mesh,
                                                          const extract::Extractor& first, extract::Extractor& second,
                                                          const Context& context);

// Fails with ErrorCode::verification if the record says that something differs. `label` names the field.
[[nodiscard]] Result<void> check_verification(const std::string& label, const VerificationRecord& record);

// Of a written mesh against what its volume gives. The distance is null where no vertex matched.
[[nodiscard]] Json json_of(const accuracy::MeshMatch& match, const std::vector<std::string>& differences);

}  // namespace isoextract::convert
