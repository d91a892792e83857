// What people type who know other programs, and what it is called here.
#pragma once

#include <string>
#include <string_view>

#include "base/error.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

// For an option that is not among `options`, the one of them that does that; empty where none is known.
[[nodiscard]] std::string hint_for_foreign_option(const OptionSet& options, std::string_view name);

// Fails with ErrorCode::usage where an output was named without -o: several inputs, the last of them named as a mesh.
[[nodiscard]] Result<void> check_for_output_among_inputs(const ConvertFlags& flags);

}  // namespace isoextract::cli
