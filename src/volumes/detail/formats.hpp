// The formats that are built in, one file each.
#pragma once

#include "volumes/volume_format.hpp"

namespace isoextract::volumes {

[[nodiscard]] const VolumeFormat& vdb_format();
[[nodiscard]] const VolumeFormat& nrrd_format();
[[nodiscard]] const VolumeFormat& nifti_format();
[[nodiscard]] const VolumeFormat& npy_format();
[[nodiscard]] const VolumeFormat& raw_format();
[[nodiscard]] const VolumeFormat& demo_format();

}  // namespace isoextract::volumes
