// `isoextract convert`: a volume in, meshes out.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

// Ends the note that relaxing changed volumes.
inline constexpr std::string_view kHowToKeepVolumes = ": --relax 0 keeps the volumes of the voxels";

// From the options to the report, which is written however the conversion ends: also where the options make none.
// `arguments` are the words of the command line, for the report.
[[nodiscard]] Result<void> run_convert(const ConvertFlags& flags, const std::vector<std::string>& arguments);

// Writes the report that the words ask for although they are no options of a conversion, unless another of them may
// name the same file. A failure is told on stderr.
void report_unread_words(const std::vector<std::string>& arguments, const Error& error);

}  // namespace isoextract::cli
