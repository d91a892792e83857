// Maps option names of other programs to the options of this one.
#pragma once

#include <string>
#include <string_view>

#include "base/error.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

// Returns a hint that names the equivalent option of `options` for another program's option, such as "--threshold".
// Returns an empty text if no equivalent is known, or if `options` lacks it.
[[nodiscard]] std::string hint_for_other_programs_option(const OptionSet& options, std::string_view name);

// Fails with ErrorCode::usage if -o is missing and the last of several inputs has a mesh's extension: the user probably
// forgot -o. Accepts an existing PLY file, since it may hold particles, and any existing file if the first input has a
// mesh's extension, too.
[[nodiscard]] Result<void> refuse_output_among_inputs(const ConvertFlags& flags);

}  // namespace isoextract::cli
