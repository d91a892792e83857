// JSON whose members keep their order, declared alone. Sources that make or read JSON include convert/json_values.hpp.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace isoextract::convert {

using Json = nlohmann::ordered_json;

}  // namespace isoextract::convert
