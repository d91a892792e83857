// The options of convert, and of verify, which does what convert did.
#pragma once

#include "cli/options.hpp"

namespace isoextract::cli {

void declare_convert(CLI::App& app, ConvertFlags& flags);
void declare_verify(CLI::App& app, VerifyFlags& flags);

}  // namespace isoextract::cli
