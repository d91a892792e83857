#include "convert/field_label.hpp"

#include <fmt/format.h>

#include "base/printable.hpp"

namespace isoextract::convert {

std::string field_label(const field::ScalarField& field) {
  constexpr std::size_t kMaxName = 200;
  const std::string source = printable(field.source);
  return field.grids > 0 ? fmt::format("{}[{}]", source, printable(field.name, kMaxName)) : source;
}

}  // namespace isoextract::convert
