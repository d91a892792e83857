// The shaders of the folder shaders, embedded at build time.
#pragma once

#include <string_view>

namespace isoextract::gl {

// The text of "mc.geom"; empty if there is no such shader.
[[nodiscard]] std::string_view shader_text(std::string_view name);

}  // namespace isoextract::gl
