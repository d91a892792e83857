#include "extract/extractor.hpp"

#include <new>
#include <stdexcept>
#include <string_view>
#include <variant>

#include <fmt/format.h>

#include "base/allocation_error.hpp"
#include "extract/mesh_assembly.hpp"

namespace isoextract::extract {
namespace {

// Fails for samples with DenseSamples::layers if the extraction needs more than some layers at a time.
Result<void> check_layers(const field::ScalarField& field, const ExtractOptions& options, std::string_view backend) {
  const auto* dense = std::get_if<field::DenseSamples>(&field.samples);
  if (dense == nullptr || dense->layers == nullptr) return {};
  const bool by_slabs = backend == "cpu" && (options.method == Method::mc || options.method == Method::mt) &&
                        !options.cap && options.nan != NanPolicy::hole;
  if (by_slabs) return {};
  return tl::unexpected(allocation_error(field.source + ": this surface needs all samples in memory or mapped"));
}

}  // namespace

Result<Extraction> Extractor::extract(const field::ScalarField& field, const ExtractOptions& options,
                                      const Context& context) {
  TRY(check_request(field, options));
  const MethodInfo& method = method_info(options.method);
  if (!has(options.method)) {
    return fail(ErrorCode::unavailable, fmt::format("the {} backend does not have {}", name(), method.title),
                {Remedy::use, Setting::cpu_backend});
  }
  TRY(check_method(method, options));
  TRY(check_layers(field, options, name()));
  TRY(context.check());
  try {
    Result<Extraction> result = run(field, options, context);
    if (result) result->mesh.name = field.name;
    return result;
  } catch (const std::bad_alloc&) {
    return tl::unexpected(
        allocation_error(field.source + ": not enough memory for the surface", {Remedy::use, Setting::parts}));
  } catch (const std::length_error&) {
    return fail(ErrorCode::input, field.source + ": the surface needs arrays that exceed the address space",
                {Remedy::use, Setting::parts});
  }
}

}  // namespace isoextract::extract
