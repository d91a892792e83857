// The structure of a file: where the attributes and the pixels are.
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
  std::uint64_t offset = 0;  // of the pixels' value
  std::uint64_t bytes = 0;   // of the pixels' value; 0 if it is encapsulated
  bool encapsulated = false;
  std::uint64_t start = 0;                      // offset of the first attribute after the file's header (group 2)
  std::uint64_t end = 0;                        // offset of the end of the attributes before the pixels
  std::shared_ptr<const std::string> inflated;  // deflated files: the inflated bytes, in which offsets count; else null
};

// Checks all attributes up to the pixels, also in nested sequences, without reading values. Throws ReadError if an
// attribute or item ends beyond the file, or has no known form. Does not check the items of compressed pixels.
// Reserves host memory for the content of a deflated file.
Structure check_structure(const std::string& path, const isoextract_plugin_host& host);

// Checks the value of a sequence whose attributes have no types (implicit, little endian; PS3.5, 6.2.2), and throws
// ReadError as check_structure() does. That function skips such values of known length, but GDCM parses them later.
void check_items(const std::string& value);

// Reads the attributes that check_structure() has checked. gdcm::Reader would guess the meaning of damaged files, and
// some of them end the process.
void read_attributes(const Structure& structure, const isoextract_plugin_host& host, gdcm::DataSet& data);

}  // namespace isoextract_dicom
