// The structure of a file: which attributes it has, and where its pixels are.
#pragma once

#include <istream>
#include <memory>
#include <string>

#include "dicom_parts.hpp"

namespace isoextract_dicom {

struct Structure {
  std::string path;
  std::string transfer_syntax, class_uid;
  bool big_endian = false;
  std::uint32_t pixels = 0;  // the tag: Pixel Data, Float Pixel Data or Double Float Pixel Data; 0 if there are none
  std::uint64_t offset = 0;  // of their value
  std::uint64_t bytes = 0;   // of their value; 0 if it is encapsulated
  bool encapsulated = false;
  std::shared_ptr<const std::string> inflated;  // a deflated file, made whole; offsets refer to it
};

// Walks through all attributes up to the pixels, without their values, and into nested sequences. Throws ReadError if
// an attribute or item ends beyond the file, or has no known form. The items of compressed pixels are not checked.
// Reserves the memory of a deflated file in the host.
Structure check_structure(const std::string& path, const isoextract_plugin_host& host);

// Checks the value of a sequence without types (implicit, little endian; PS3.5, 6.2.2) in the same way. check_structure()
// does not see it where its length is known, and GDCM makes items of it later.
void check_items(const std::string& value);

// Opens the file, or its inflated bytes.
std::unique_ptr<std::istream> open_stream(const Structure& structure);

}  // namespace isoextract_dicom
