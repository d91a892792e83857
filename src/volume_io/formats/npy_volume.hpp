// Interprets a NumPy array as a volume, for .npy files and members of .npz files.
#pragma once

#include <string>

#include "base/error.hpp"
#include "volume_io/detail/dense_format.hpp"
#include "volume_io/npy_header.hpp"

namespace isoextract::volume_io {

// Returns everything but the location of the samples. Axes are [z, y, x], or [t, z, y, x] with several volumes;
// options.axis_order can make them [x, y, z] and [t, x, y, z]. If the options select a component and the array has four
// axes or more, the last axis holds the components: [z, y, x, c] or [t, z, y, x, c]. An array of complex numbers has
// two components and no axis of components. With ReadOptions::flat, an array of two axes [y, x] is one slice. Drops
// leading axes of length 1 while more axes remain than one volume needs. `name` is for messages. Fails with
// ErrorCode::input for other numbers of axes, unsupported types and sizes that checked_dims() refuses.
[[nodiscard]] Result<DenseFile> npy_volume(const std::string& name, const NpyHeader& header,
                                           const ReadOptions& options);

}  // namespace isoextract::volume_io
