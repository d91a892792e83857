// JSON whose members keep their order. What makes or reads some includes <nlohmann/json.hpp>; others need this alone.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace isoextract::convert {

using Json = nlohmann::ordered_json;

}  // namespace isoextract::convert
