// Input names: paths of files, and texts that are no paths.
#pragma once

#include <string>

namespace isoextract::batch {

// Returns false for demo:NAME and any other text with the prefix of a volume format.
[[nodiscard]] bool is_file_name(const std::string& input);

}  // namespace isoextract::batch
