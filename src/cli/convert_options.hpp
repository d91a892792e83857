// The options of convert.
#pragma once

#include "cli/options.hpp"

namespace isoextract::cli {

void declare_convert(CLI::App& app, ConvertFlags& flags);

}  // namespace isoextract::cli
