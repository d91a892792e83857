#include "convert/field_label.hpp"

#include <fmt/format.h>

#include "base/printable.hpp"

namespace isoextract::convert {

std::string field_label(const field::ScalarField& field) {
  const std::string source = printable(field.source);
  return field.grids > 0 ? fmt::format("{}[{}]", source, field.grid) : source;
}

}  // namespace isoextract::convert
