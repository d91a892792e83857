// The options of `simulate jet`.
#pragma once

#include "cli/options.hpp"

namespace isoextract::cli {

void declare_jet(CLI::App& app, JetFlags& flags);

}  // namespace isoextract::cli
