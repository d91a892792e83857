// Files with samples alone (.raw, .img) and the header files that describe them: only the header names the volume.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace isoextract::batch {

// Returns whether the file has samples only and its header lies beside it: scan.raw beside scan.nhdr.
[[nodiscard]] bool has_header_beside(const std::string& folder, const std::string& name);

// Returns the inputs without sample files whose header is another input, such as a shell's list for tooth/* with
// tooth.nhdr and tooth.raw.
[[nodiscard]] std::vector<std::string> without_sample_files(std::span<const std::string> inputs);

}  // namespace isoextract::batch
