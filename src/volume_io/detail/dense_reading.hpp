// Reads the samples of a dense file into a field: selects volume and component, then maps or reads them.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "field/scalar_field.hpp"
#include "files/file_part.hpp"
#include "volume_io/detail/dense_format.hpp"

namespace isoextract::volume_io {

// Maps the samples if their layout in the file fits; else reads them into memory that is reserved for as long as they
// live. Vector lengths are computed from scaled components. The lengths are f64 if the components are f64 or integers
// that float cannot represent, else f32.
//
// Fails as set_placement() does, and with ErrorCode::input
// - if the file is shorter than its header says, or longer and DenseFile::size_is_exact is set,
// - if there are several volumes or components and none is selected,
// - if double cannot represent a 64-bit integer that is not options.no_data; with options.label_ids as index_ids()
// does.
[[nodiscard]] Result<field::ScalarField> read_dense(const files::InputFile& file, DenseFile dense, std::string name,
                                                    const ReadOptions& options);

// Returns the bytes that the selected volume depends on: the header, and the samples of all its components.
// Returns whole files if options.volume is not set, if the samples are compressed, or if the samples of one volume
// are not contiguous.
[[nodiscard]] Result<std::vector<files::FilePart>> find_volume_parts(const files::InputFile& file,
                                                                     const DenseFile& dense,
                                                                     const ReadOptions& options);

}  // namespace isoextract::volume_io
