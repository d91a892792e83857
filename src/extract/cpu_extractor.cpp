#include "base/machine.hpp"
#include "extract/dense_extractor.hpp"
#include "extract/extractor.hpp"
#include "extract/mesh_assembly.hpp"
#include "extract/sparse_extractor.hpp"

namespace isoextract {
namespace {

class CpuExtractor final : public Extractor {
 public:
  [[nodiscard]] std::string_view name() const override { return "cpu"; }
  [[nodiscard]] std::string device() const override { return cpu_name(); }

  [[nodiscard]] Result<Extraction> extract(const ScalarField& field, const ExtractOptions& options) override {
    return extract_guarded(field, options, [&](const auto& samples) { return extract_from(field, samples, options); });
  }

 private:
  static Result<Extraction> extract_from(const ScalarField& field, const DenseSamples& samples,
                                         const ExtractOptions& options) {
    return extract_dense(field, samples, options);
  }
  static Result<Extraction> extract_from(const ScalarField& field, const SparseSamples& samples,
                                         const ExtractOptions& options) {
    return extract_sparse(field, samples, options);
  }
};

}  // namespace

std::unique_ptr<Extractor> make_cpu_extractor() { return std::make_unique<CpuExtractor>(); }

}  // namespace isoextract
