#include <new>
#include <stdexcept>

#include <fmt/format.h>

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
    if (auto sound = check_request(field, options); !sound) return tl::unexpected(sound.error());
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
