// The stage that compares one backend with another; what a verification found, and its JSON: the report's section
// "verification", and what `verify --json` prints.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/stopwatch.hpp"
#include "convert/json_values.hpp"
#include "extract/extractor.hpp"
#include "measure/extraction_comparison.hpp"
#include "measure/mesh_match.hpp"

namespace isoextract::convert {

// Of one surface, extracted by two backends.
struct VerificationRecord {
  double iso = 0;
  std::array<std::string, 2> backends;  // the one whose mesh is written comes first
  measure::ExtractionComparison comparison;
  std::vector<std::string> differences;  // none if it passed
  StageTime time;                        // of the second extraction and the comparison
};

[[nodiscard]] Json json_of(const VerificationRecord& record);

// Extracts with `second` what `first` made `mesh` of, and compares. `options` are those of `mesh`, edge keys among
// them. Fails as the extraction and the comparison do; what differs is no failure here.
[[nodiscard]] Result<VerificationRecord> compare_backends(const field::ScalarField& field,
                                                          const extract::ExtractOptions& options,
                                                          const mesh::Mesh& mesh, const extract::Extractor& first,
                                                          extract::Extractor& second, const Context& context);

// Fails with ErrorKind::verification if the record says that something differs. `label` names the field.
[[nodiscard]] Result<void> check_verification(const std::string& label, const VerificationRecord& record);

// Of a written mesh against what its volume gives.
[[nodiscard]] Json json_of(const measure::MeshMatch& match, const std::vector<std::string>& differences);

}  // namespace isoextract::convert
