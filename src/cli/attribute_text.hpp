// What compare tells of the attributes of two meshes.
#pragma once

#include "cli/layout.hpp"
#include "convert/json_values.hpp"
#include "measure/attribute_match.hpp"

namespace isoextract::cli {

// Nothing where neither mesh has any.
void add_attributes(NamedLines& lines, const measure::AttributeMatches& matches);

[[nodiscard]] convert::Json attributes_json(const measure::AttributeMatches& matches);

}  // namespace isoextract::cli
