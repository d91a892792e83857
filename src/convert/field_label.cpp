#include "convert/field_label.hpp"

#include <filesystem>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "files/unpacked_files.hpp"

namespace isoextract::convert {

std::string field_label(const field::ScalarField& field) {
  const std::string source = printable(field.source);
  return field.grids > 0 ? fmt::format("{}[{}]", source, field.grid) : source;
}

std::string stem_of_file(const std::string& input) {
  const std::filesystem::path name = files::name_without_packing(std::filesystem::path(input).filename());
  return name.stem().string();
}

}  // namespace isoextract::convert
