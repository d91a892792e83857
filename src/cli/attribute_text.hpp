// Reports how the attributes of two meshes compare, for `compare`.
#pragma once

#include "accuracy/attribute_match.hpp"
#include "cli/layout.hpp"
#include "convert/json_type.hpp"

namespace isoextract::cli {

// Adds nothing if neither mesh has attributes.
void add_attributes(NamedLines& lines, const accuracy::AttributeMatches& matches);

[[nodiscard]] convert::Json attributes_json(const accuracy::AttributeMatches& matches);

}  // namespace isoextract::cli
