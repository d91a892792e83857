// What a NumPy array is as a volume, wherever its bytes are: in a file of its own or as a member of an .npz.
#pragma once

#include <string>

#include "base/error.hpp"
#include "volume_io/detail/dense_format.hpp"
#include "volume_io/npy_header.hpp"

namespace isoextract::volume_io {

// All of it but where the samples are: [z, y, x], or with a leading axis of volumes [t, z, y, x]. Where options ask for
// a component, a last one of components: [z, y, x, c] or [t, z, y, x, c]; complex numbers have two without one.
// `name` is for messages.
[[nodiscard]] Result<DenseFile> npy_volume(const std::string& name, const NpyHeader& header,
                                           const ReadOptions& options);

}  // namespace isoextract::volume_io
