#include "cli/field_label.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

namespace isoextract {

std::string field_label(const ScalarField& field) {
  // Only sparse formats have grids with names.
  const bool has_grids = std::holds_alternative<SparseSamples>(field.samples);
  return has_grids ? fmt::format("{}[{}]", field.source, field.name) : field.source;
}

std::uint64_t peak_memory() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace isoextract
