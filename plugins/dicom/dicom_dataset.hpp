// Values of a GDCM data set. Every function returns an empty value for attributes that are missing or malformed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <gdcmDataSet.h>
#include <gdcmSequenceOfItems.h>

#include "dicom_parts.hpp"

namespace isoextract_dicom {

// Returns a text without padding: the whole value, with its backslashes. Valid UTF-8 for the character sets UTF-8 and
// Latin-1; other characters become "?".
std::string text_of(const gdcm::DataSet& data, const gdcm::Tag& tag, const std::string& character_set = {});
// Numbers in text (DS, IS), separated by backslashes. Empty if one of them is no finite number.
std::vector<double> decimals_of(const gdcm::DataSet& data, const gdcm::Tag& tag);
std::optional<double> decimal_of(const gdcm::DataSet& data, const gdcm::Tag& tag);
// Returns binary numbers: US, UL, FD.
std::vector<std::uint32_t> shorts_of(const gdcm::DataSet& data, const gdcm::Tag& tag);
std::optional<std::uint32_t> short_of(const gdcm::DataSet& data, const gdcm::Tag& tag);
std::optional<std::uint32_t> long_of(const gdcm::DataSet& data, const gdcm::Tag& tag);
std::optional<double> double_of(const gdcm::DataSet& data, const gdcm::Tag& tag);
// Returns a time of day (TM, DT without its date) in seconds.
std::optional<double> seconds_of(const std::string& time);

// The items of a sequence, which live as long as this object.
class Items {
 public:
  Items(const gdcm::DataSet& data, const gdcm::Tag& tag);
  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] const gdcm::DataSet& operator[](std::size_t index) const;

 private:
  gdcm::SmartPointer<gdcm::SequenceOfItems> items_;
};

// Fills Object::frames from an object's attributes and, in enhanced objects, from the functional groups of its frames
// (PS3.3, C.7.6.16). Object::pixels are known.
void read_frames(const gdcm::DataSet& data, Object& object);
// Fills the members of a segmentation (PS3.3, C.8.20), except for the segments of its frames.
void read_segments(const gdcm::DataSet& data, const std::string& character_set, Object& object);

}  // namespace isoextract_dicom
