#include "volumes/volume_format.hpp"

#include <algorithm>
#include <array>

#include "volumes/detail/formats.hpp"

namespace isoextract::volumes {

std::span<const VolumeFormat* const> volume_formats() {
  static const std::array<const VolumeFormat*, 6> formats{
      &vdb_format(),    //
      &nrrd_format(),   //
      &nifti_format(),  //
      &npy_format(),    //
      &raw_format(),    //
      &demo_format(),
  };
  return formats;
}

const VolumeFormat* find_volume_format(std::string_view id) {
  for (const VolumeFormat* format : volume_formats()) {
    if (format->about().id == id) return format;
  }
  return nullptr;
}

}  // namespace isoextract::volumes
