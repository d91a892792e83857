// Samples without a header: the options or another file state their layout. Private to the readers of raw files.
#pragma once

#include "base/error.hpp"
#include "files/file_bytes.hpp"
#include "volume_io/detail/dense_format.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::volume_io {

// Locates the samples of a raw file. Fails with ErrorCode::usage for dims below 1, and with ErrorCode::input if the
// file does not have the size of one or more volumes with this layout.
[[nodiscard]] Result<DenseFile> open_raw(const files::InputFile& file, const RawLayout& layout, AxisOrder order);

}  // namespace isoextract::volume_io
