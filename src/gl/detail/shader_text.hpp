// The files of the folder shaders, embedded at build time.
#pragma once

#include <string_view>

namespace isoextract::gl {

// Returns the text of a shader file such as "mc.geom"; empty if there is none.
[[nodiscard]] std::string_view shader_text(std::string_view name);

}  // namespace isoextract::gl
