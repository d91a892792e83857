#include "extract/sparse_extractor.hpp"
namespace isoextract {
Result<Extraction> extract_sparse(const ScalarField&, const SparseSamples&, const ExtractOptions&) {
  return Extraction{};
}
}  // namespace isoextract
