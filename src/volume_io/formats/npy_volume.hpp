// Interprets a NumPy array as a volume, for .npy files and members of .npz files.
#pragma once

#include <string>

#include "base/error.hpp"
#include "volume_io/detail/dense_format.hpp"
#include "volume_io/npy_header.hpp"

namespace isoextract::volume_io {

// Returns everything but the location of the samples. Axes are [z, y, x], or [t, z, y, x] with several volumes. If the
// options select a component, a last axis of components is added: [z, y, x, c] or [t, z, y, x, c]. Complex numbers have
// two components without such an axis. `name` is for messages.
[[nodiscard]] Result<DenseFile> npy_volume(const std::string& name, const NpyHeader& header,
                                           const ReadOptions& options);

}  // namespace isoextract::volume_io
