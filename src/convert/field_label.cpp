#include "convert/field_label.hpp"

#include <fmt/format.h>

namespace isoextract::convert {

std::string field_label(const field::ScalarField& field) {
  // Only sparse formats have grids with names.
  const bool has_grids = std::holds_alternative<field::SparseSamples>(field.samples);
  return has_grids ? fmt::format("{}[{}]", field.source, field.name) : field.source;
}

}  // namespace isoextract::convert
