// Reports how the attributes of two meshes compare, for `compare`.
#pragma once

#include "accuracy/attribute_match.hpp"
#include "cli/layout.hpp"
#include "convert/json_type.hpp"

namespace isoextract::cli {

// Adds a section with one line per attribute (colors count as one); nothing if neither mesh has attributes.
void add_attributes(NamedLines& lines, const accuracy::AttributeMatches& matches);

[[nodiscard]] convert::Json attributes_json(const accuracy::AttributeMatches& matches);

}  // namespace isoextract::cli
