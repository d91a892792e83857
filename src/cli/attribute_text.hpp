// What compare tells of the attributes of two meshes.
#pragma once

#include "accuracy/attribute_match.hpp"
#include "cli/layout.hpp"
#include "convert/json_type.hpp"

namespace isoextract::cli {

// Nothing where neither mesh has any.
void add_attributes(NamedLines& lines, const accuracy::AttributeMatches& matches);

[[nodiscard]] convert::Json attributes_json(const accuracy::AttributeMatches& matches);

}  // namespace isoextract::cli
