#include "base/machine.hpp"
#include "extract/detail/dense_extractor.hpp"
#include "extract/detail/sparse_extractor.hpp"
#include "extract/extractor.hpp"

namespace isoextract::extract {
namespace {

class CpuExtractor final : public Extractor {
 public:
  [[nodiscard]] std::string_view name() const override { return "cpu"; }
  [[nodiscard]] std::string device() const override { return cpu_name(); }
  [[nodiscard]] bool has(Method method) const override { return method_info(method).run_on_cpu != nullptr; }

 private:
  [[nodiscard]] Result<Extraction> run(const field::ScalarField& field, const ExtractOptions& options,
                                       const Context& context) override {
    return method_info(options.method).run_on_cpu(field, options, context);
  }
};

}  // namespace

Result<Extraction> extract_by_cells(const field::ScalarField& field, const ExtractOptions& options,
                                    const Context& context) {
  if (const auto* dense = std::get_if<field::DenseSamples>(&field.samples)) {
    return extract_dense(field, *dense, options, context);
  }
  return extract_sparse(field, std::get<field::SparseSamples>(field.samples), options, context);
}

std::unique_ptr<Extractor> make_cpu_extractor() { return std::make_unique<CpuExtractor>(); }

}  // namespace isoextract::extract
