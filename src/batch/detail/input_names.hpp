// Names of inputs: those of files, and texts that stand for no file.
#pragma once

#include <string>

namespace isoextract::batch {

// False for demo:NAME, and for what else starts with the prefix of a volume format.
[[nodiscard]] bool is_file_name(const std::string& input);

}  // namespace isoextract::batch
