// Compares the surfaces of two backends, and returns the result as a record and as a stage report (section
// "verification"). Also formats the comparison of a written mesh as JSON (`verify --json`).
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

// Comparison of one surface as extracted by two backends.
struct VerificationRecord {
  double iso = 0;
  std::array<std::string, 2> backends;  // first the backend whose mesh is written
  std::string not_applicable;           // why nothing was compared, as a sentence without its full stop; else empty
  accuracy::ExtractionComparison comparison;
  std::vector<std::string> differences;  // empty if the verification passed
  StageTime time;                        // of the second extraction and the comparison; 0 without them
};

// Returns why the surfaces of a method from two backends cannot be compared: a backend lacks the method, or the
// method gives vertices without edge keys. Empty if they can.
[[nodiscard]] std::string why_not_comparable(const extract::MethodInfo& method, const extract::Extractor& first,
                                             const extract::Extractor& second);

// Returns the report about a surface of the field named `label`.
[[nodiscard]] StageReport report_of(const VerificationRecord& record, const std::string& label);

// Extracts the surface of `mesh` again with `second` and compares the two meshes. If why_not_comparable() gives a
// reason, only records the reason. `first` made `mesh` by `method` with `options`, which ask for edge keys if the
// method has them. Fails if the extraction or the comparison fails, but not if the surfaces differ.
[[nodiscard]] Result<VerificationRecord> compare_backends(const field::ScalarField& field,
                                                          const extract::ExtractOptions& options,
                                                          const extract::MethodInfo& method, const mesh::Mesh& mesh,
                                                          const extract::Extractor& first, extract::Extractor& second,
                                                          const Context& context);

// Fails with ErrorCode::verification if the record has differences. `label` names the field.
[[nodiscard]] Result<void> check_verification(const std::string& label, const VerificationRecord& record);

// Returns JSON of the comparison of a written mesh with its volume's surface. `distance` is null if no vertex matched.
[[nodiscard]] Json json_of(const accuracy::MeshMatch& match, const std::vector<std::string>& differences);

}  // namespace isoextract::convert
