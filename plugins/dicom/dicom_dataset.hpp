// Values of a GDCM data set. The functions ..._of() return an empty value if the attribute is missing or malformed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <gdcmDataSet.h>
#include <gdcmSequenceOfItems.h>

#include "dicom_parts.hpp"

namespace isoextract_dicom {

// Returns a text as UTF-8 without padding: the whole value, with its backslashes. Converts from the character sets
// UTF-8 and Latin-1; in other sets, bytes above 127 become "?".
std::string text_of(const gdcm::DataSet& data, const gdcm::Tag& tag, const std::string& character_set = {});
// Returns the numbers of a text (DS, IS), separated by backslashes; empty if one of them is not a finite number.
std::vector<double> decimals_of(const gdcm::DataSet& data, const gdcm::Tag& tag);
std::optional<double> decimal_of(const gdcm::DataSet& data, const gdcm::Tag& tag);
// Returns binary numbers: US, UL, FD.
std::vector<std::uint32_t> uint16s_of(const gdcm::DataSet& data, const gdcm::Tag& tag);
std::optional<std::uint32_t> uint16_of(const gdcm::DataSet& data, const gdcm::Tag& tag);
std::optional<std::uint32_t> uint32_of(const gdcm::DataSet& data, const gdcm::Tag& tag);
std::optional<double> double_of(const gdcm::DataSet& data, const gdcm::Tag& tag);
// Returns the seconds since midnight of a time (TM), or of a date and time (DT), whose date is skipped.
std::optional<double> seconds_of(const std::string& time);

// The items of a sequence, valid while this object lives; none if the attribute is missing. The constructor throws
// ReadError if the attribute is not a sequence or is damaged.
class Items {
 public:
  Items(const gdcm::DataSet& data, const gdcm::Tag& tag);
  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] const gdcm::DataSet& operator[](std::size_t index) const;

 private:
  gdcm::SmartPointer<gdcm::SequenceOfItems> items_;
};

// Fills Object::frames and is_stacked from the attributes and, in enhanced objects, from the functional groups of
// frames (PS3.3, C.7.6.16). Needs pixels.frames; throws ReadError if the number of groups differs from it.
void read_frames(const gdcm::DataSet& data, Object& object);
// Fills the members of a segmentation (PS3.3, C.8.20) except Frame::segment; leaves other objects unchanged. Throws
// ReadError for an unknown type, a repeated number, or no segments.
void read_segments(const gdcm::DataSet& data, const std::string& character_set, Object& object);

}  // namespace isoextract_dicom
