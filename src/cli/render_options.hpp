// The options of `isoextract render`.
#pragma once

#include "cli/options.hpp"

namespace isoextract::cli {

void declare_render(CLI::App& app, RenderFlags& flags);

}  // namespace isoextract::cli
