#include "convert/field_label.hpp"

#include <fmt/format.h>

namespace isoextract::convert {

std::string field_label(const field::ScalarField& field) {
  return field.grids > 0 ? fmt::format("{}[{}]", field.source, field.name) : field.source;
}

}  // namespace isoextract::convert
