// Declares the JSON type (members keep their order). Sources that make or read JSON include convert/json_values.hpp.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace isoextract::convert {

using Json = nlohmann::ordered_json;

}  // namespace isoextract::convert
