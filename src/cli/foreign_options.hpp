// Maps option names of other programs to the options of this one.
#pragma once

#include <string>
#include <string_view>

#include "base/error.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

// Returns a hint that names the equivalent option, for a name that is not among `options`; empty if none is known.
[[nodiscard]] std::string hint_for_other_programs_option(const OptionSet& options, std::string_view name);

// Fails with ErrorCode::usage if the last of several inputs has a mesh's extension, so that -o was probably forgotten.
[[nodiscard]] Result<void> refuse_output_among_inputs(const ConvertFlags& flags);

}  // namespace isoextract::cli
