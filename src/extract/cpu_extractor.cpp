#include <cmath>
#include <new>
#include <stdexcept>

#include <fmt/format.h>

#include "extract/dense_extractor.hpp"
#include "extract/extractor.hpp"
#include "extract/sparse_extractor.hpp"

namespace isoextract {
namespace {

class CpuExtractor final : public Extractor {
 public:
  [[nodiscard]] std::string_view name() const override { return "cpu"; }

  [[nodiscard]] Result<Extraction> extract(const ScalarField& field, const ExtractOptions& options) override {
    if (!std::isfinite(options.iso)) {
      return fail(ErrorKind::usage, fmt::format("the iso value must be a finite number, found {}", options.iso));
    }
    if (!options.output_from_index.is_regular()) {
      return fail(ErrorKind::input, fmt::format("{}: its transform flattens space or is not finite", field.source),
                  "replace it with --spacing and --origin");
    }
    try {
      Result<Extraction> result =
          std::visit([&](const auto& samples) { return extract_from(field, samples, options); }, field.samples);
      if (result) result->mesh.name = field.name;
      return result;
    } catch (const std::bad_alloc&) {
      return fail(ErrorKind::input, fmt::format("{}: not enough memory for the surface", field.source),
                  "extract it in parts with --roi");
    } catch (const std::length_error&) {
      return fail(ErrorKind::input, fmt::format("{}: the surface is larger than memory can be", field.source),
                  "extract it in parts with --roi");
    }
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
