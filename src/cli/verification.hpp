// One backend against another, for `verify` and for `convert --verify`: doing it, and its words.
#pragma once

#include <string>

#include "base/error.hpp"
#include "convert/verification_record.hpp"
#include "extract/extractor.hpp"

namespace isoextract::cli {

// Extracts with `second` what `first` made `mesh` of, and compares. `options` are those of `mesh`, edge keys among
// them. Fails as the extraction and the comparison do; what differs is no failure here.
[[nodiscard]] Result<convert::VerificationRecord> compare_backends(const field::ScalarField& field,
                                                                   const extract::ExtractOptions& options,
                                                                   const mesh::Mesh& mesh,
                                                                   const extract::Extractor& first,
                                                                   extract::Extractor& second, const Context& context);

// Fails with ErrorKind::verification if the record says that something differs. `label` names the field.
[[nodiscard]] Result<void> check_verification(const std::string& label, const convert::VerificationRecord& record);

// "verified at iso 0.5: gpu gives the same 12 triangles and 8 vertices as cpu, at most 0.5 ulps apart; 0.01 s"
[[nodiscard]] std::string verification_summary(const convert::VerificationRecord& record);

// The table that `verify` prints.
[[nodiscard]] std::string verification_table(const std::string& label, const convert::VerificationRecord& record);

}  // namespace isoextract::cli
