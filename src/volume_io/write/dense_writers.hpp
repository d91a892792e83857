// Headers of files with dense samples. The samples follow the header in the layout they have in memory.
#pragma once

#include <string>
#include <string_view>

#include "field/scalar_field.hpp"

namespace isoextract::volume_io {

// Returns the header of an array [z, y, x], or [y, x] for one layer; see npy_text.hpp.
[[nodiscard]] std::string npy_header(const field::DenseSamples& samples);

// Returns a header with space directions and origin, which need version 4
// (http://teem.sourceforge.net/nrrd/format.html). Names the space and its unit if the field has names that NRRD knows.
// NRRD has no f16.
[[nodiscard]] std::string nrrd_header(const field::ScalarField& field, const field::DenseSamples& samples);

// Returns the XML before the samples of VTK image data with one appended raw array, named like the field
// (https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html), and the number of bytes of the samples,
// which is part of the appended data. kVtiTrailer follows the samples. VTK has no f16. The axes must be perpendicular.
[[nodiscard]] std::string vti_header(const field::ScalarField& field, const field::DenseSamples& samples);
inline constexpr std::string_view kVtiTrailer = "\n  </AppendedData>\n</VTKFile>\n";

// Returns whether the axes of the samples are perpendicular to each other, up to rounding.
[[nodiscard]] bool has_perpendicular_axes(const field::Affine& index_to_world);

}  // namespace isoextract::volume_io
