// Segments of a segmentation that 3D Slicer wrote (.seg.nrrd): names, colors, label values and layers, in key/value
// pairs of the NRRD header. Private to the NRRD reader.
//
//   Segment0_Name:=Left kidney      else Segment0_ID, else Segment0
//   Segment0_Color:=0.8 0.2 0.1     sRGB, each clamped to 0 to 1
//   Segment0_LabelValue:=1          else 1, as in files of Slicer 4.10 and older
//   Segment0_Layer:=0               index along the axis of kind "list"; else the segment's number, as in Slicer 4.10
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::volume_io {

inline constexpr std::string_view kSegmentKey = "Segment";  // a key starts with it and the segment's number

// Parses the lines "SegmentN_KEY:=VALUE" of a header; skips keys that are not listed above. `layers` is the number of
// volumes: with one, the labels have no layer. Fails with ErrorCode::input for a value that is not as above, for a
// layer that the file does not have, and for two segments with the same label in one layer. `file` starts the message.
[[nodiscard]] Result<std::vector<field::LabelName>> parse_segments(const std::string& file,
                                                                   std::span<const std::string> lines,
                                                                   std::uint64_t layers);

}  // namespace isoextract::volume_io
