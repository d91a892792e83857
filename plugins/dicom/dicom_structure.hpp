// The structure of a file: which attributes it has, and where its pixels are.
#pragma once

#include <memory>
#include <string>

#include "dicom_parts.hpp"

namespace isoextract_dicom {

struct Structure {
  std::string path;
  std::string transfer_syntax, class_uid;
  bool big_endian = false;
  bool is_explicit = true;   // each attribute has its type (VR)
  std::uint32_t pixels = 0;  // the tag: Pixel Data, Float Pixel Data or Double Float Pixel Data; 0 if there are none
  std::uint64_t offset = 0;  // of their value
  std::uint64_t bytes = 0;   // of their value; 0 if it is encapsulated
  bool encapsulated = false;
  std::uint64_t start = 0;                      // of the attributes after the file's header
  std::uint64_t end = 0;                        // of those before the pixels
  std::shared_ptr<const std::string> inflated;  // the inflated bytes of a deflated file; offsets refer to them
};

// Walks through all attributes up to the pixels, without their values, and into nested sequences. Throws ReadError if
// an attribute or item ends beyond the file, or has no known form. The items of compressed pixels are not checked.
// Reserves the memory of a deflated file in the host.
Structure check_structure(const std::string& path, const isoextract_plugin_host& host);

// Checks the value of a sequence without types (implicit, little endian; PS3.5, 6.2.2) in the same way.
// check_structure() does not see it where its length is known, and GDCM makes items of it later.
void check_items(const std::string& value);

// Reads the checked attributes. A reader of GDCM would guess what damaged files mean, and ends the process on some.
void read_attributes(const Structure& structure, const isoextract_plugin_host& host, gdcm::DataSet& data);

}  // namespace isoextract_dicom
