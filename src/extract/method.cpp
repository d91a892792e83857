#include "extract/method.hpp"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "extract/extractor.hpp"

namespace isoextract::extract {
namespace {

consteval bool in_order_of_the_enum() {
  for (std::size_t m = 0; m < kMethods.size(); ++m) {
    if (kMethods[m].method != static_cast<Method>(m)) return false;
  }
  return true;
}
static_assert(in_order_of_the_enum());

}  // namespace

std::vector<MethodInfo> interpolant_methods() {
  std::vector<MethodInfo> methods;
  std::ranges::copy_if(kMethods, std::back_inserter(methods),
                       [](const MethodInfo& method) { return method.traits.follows_interpolant; });
  return methods;
}

std::string why_no_edge_keys(const MethodInfo& method) {
  if (method.traits.vertices_on_edges) return "";
  return fmt::format("{}: the vertices do not lie on edges of the grid", method.title);
}

std::string why_no_crossings(const MethodInfo& method) {
  if (method.traits.follows_interpolant) return "";
  return fmt::format("{}: the surface does not follow the field between its samples", method.title);
}

std::string why_no_gradient_normals(const MethodInfo& method) {
  if (method.traits.gradient_normals) return "";
  return fmt::format("{}: the method has no normals from the field's gradient", method.title);
}

std::string why_no_holes(const MethodInfo& method) {
  if (!method.traits.always_closed) return "";
  return fmt::format("{}: the method always closes the surface and cannot leave holes at NaN samples", method.title);
}

Result<void> check_method(const MethodInfo& method, const ExtractOptions& options) {
  if (options.edge_keys && !method.traits.vertices_on_edges) return fail(ErrorCode::usage, why_no_edge_keys(method));
  if (options.smooth_normals && !method.traits.gradient_normals) {
    return fail(ErrorCode::usage, why_no_gradient_normals(method));
  }
  if (options.nan == NanPolicy::hole && method.traits.always_closed) {
    return fail(ErrorCode::usage, why_no_holes(method));
  }
  return {};
}

}  // namespace isoextract::extract
