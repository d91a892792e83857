#include "batch/detail/input_names.hpp"

#include <algorithm>

#include "volume_io/volume_format.hpp"

namespace isoextract::batch {

bool is_file_name(const std::string& input) {
  return std::ranges::none_of(volume_io::volume_formats(), [&](const volume_io::VolumeFormat* format) {
    const std::string& prefix = format->about().prefix;
    return !prefix.empty() && input.starts_with(prefix);
  });
}

}  // namespace isoextract::batch
