#include "base/machine.hpp"
#include "extract/detail/dense_extractor.hpp"
#include "extract/detail/sparse_extractor.hpp"
#include "extract/extractor.hpp"
#include "extract/mesh_assembly.hpp"

namespace isoextract::extract {
namespace {

class CpuExtractor final : public Extractor {
 public:
  [[nodiscard]] std::string_view name() const override { return "cpu"; }
  [[nodiscard]] std::string device() const override { return cpu_name(); }

  [[nodiscard]] Result<Extraction> extract(const field::ScalarField& field, const ExtractOptions& options) override {
    return extract_guarded(field, options, [&](const auto& samples) { return extract_from(field, samples, options); });
  }

 private:
  static Result<Extraction> extract_from(const field::ScalarField& field, const field::DenseSamples& samples,
                                         const ExtractOptions& options) {
    return extract_dense(field, samples, options);
  }
  static Result<Extraction> extract_from(const field::ScalarField& field, const field::SparseSamples& samples,
                                         const ExtractOptions& options) {
    return extract_sparse(field, samples, options);
  }
};

}  // namespace

std::unique_ptr<Extractor> make_cpu_extractor() { return std::make_unique<CpuExtractor>(); }

}  // namespace isoextract::extract
