#include "cli/field_label.hpp"

#include <fmt/format.h>

namespace isoextract::cli {

std::string field_label(const field::ScalarField& field) {
  return field.grids > 0 ? fmt::format("{}[{}]", field.source, field.name) : field.source;
}

}  // namespace isoextract::cli
