// Builds ZIP files byte by byte, so that tests can insert wrong numbers.
#pragma once

#include <string>
#include <vector>

#include <zlib.h>

#include "unit/volume_io/volume_files.hpp"

namespace isoextract::test {

// Returns an array in NumPy's format.
inline std::string npy_array(const std::string& descr, const std::string& shape, const std::string& samples,
                             bool fortran = false) {
  std::string text =
      "{'descr': '" + descr + "', 'fortran_order': " + (fortran ? "True" : "False") + ", 'shape': " + shape + ", }";
  while ((10 + text.size() + 1) % 64 != 0) text += ' ';
  text += '\n';
  return std::string("\x93NUMPY\1\0", 8) + pack(static_cast<std::uint16_t>(text.size())) + text + samples;
}

// Compresses to raw Deflate.
inline std::string deflate(const std::string& bytes) {
  z_stream stream{};
  if (::deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY) != Z_OK) throw 0;
  std::string packed(::deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  ::deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  ::deflateEnd(&stream);
  return packed;
}

// A member and its directory entry.
struct ZipPart {
  std::string name;
  std::string stored;  // bytes in the file
  std::uint16_t method = 0;
  std::uint32_t inflated = 0;
  std::uint32_t crc = 0;
  std::uint32_t packed = 0;
  std::uint16_t flags = 0;
  bool zip64 = false;                // its sizes are in the ZIP64 field
  std::uint16_t local_extra = 20;    // NumPy reserves room for 64-bit sizes in the local header
  std::int64_t header_moved_by = 0;  // offset error of the local header's position
};

inline ZipPart zip_part(const std::string& name, const std::string& content, bool packed) {
  ZipPart part{name, packed ? deflate(content) : content};
  part.method = packed ? 8 : 0;
  part.inflated = static_cast<std::uint32_t>(content.size());
  part.packed = static_cast<std::uint32_t>(part.stored.size());
  part.crc = static_cast<std::uint32_t>(
      ::crc32(0, reinterpret_cast<const Bytef*>(content.data()), static_cast<uInt>(content.size())));
  return part;
}

inline std::string zip_bytes(const std::vector<ZipPart>& parts, const std::string& comment = "") {
  std::string file;
  std::string directory;
  for (const ZipPart& part : parts) {
    const auto at = static_cast<std::uint32_t>(static_cast<std::int64_t>(file.size()) + part.header_moved_by);
    const auto name_size = static_cast<std::uint16_t>(part.name.size());
    file += pack(std::uint32_t{0x04034b50}) + pack(std::uint16_t{45}) + pack(part.flags) + pack(part.method) +
            pack(std::uint32_t{0}) + pack(part.crc) + pack(part.packed) + pack(part.inflated) + pack(name_size) +
            pack(part.local_extra) + part.name + std::string(part.local_extra, '\0') + part.stored;
    std::string extra;
    if (part.zip64) {
      // Inserts another field before it.
      extra = pack(std::uint16_t{9}) + pack(std::uint16_t{2}) + "ab";
      extra += pack(std::uint16_t{1}) + pack(std::uint16_t{24}) + pack(std::uint64_t{part.inflated}) +
               pack(std::uint64_t{part.packed}) + pack(std::uint64_t{at});
    }
    const std::uint32_t all = 0xffffffff;
    directory += pack(std::uint32_t{0x02014b50}) + pack(std::uint16_t{45}) + pack(std::uint16_t{45}) +
                 pack(part.flags) + pack(part.method) + pack(std::uint32_t{0}) + pack(part.crc) +
                 pack(part.zip64 ? all : part.packed) + pack(part.zip64 ? all : part.inflated) + pack(name_size) +
                 pack(static_cast<std::uint16_t>(extra.size())) + pack(std::uint16_t{0}) + std::string(8, '\0') +
                 pack(part.zip64 ? all : at) + part.name + extra;
  }
  const auto count = static_cast<std::uint16_t>(parts.size());
  const auto offset = static_cast<std::uint32_t>(file.size());
  return file + directory + pack(std::uint32_t{0x06054b50}) + std::string(4, '\0') + pack(count) + pack(count) +
         pack(static_cast<std::uint32_t>(directory.size())) + pack(offset) +
         pack(static_cast<std::uint16_t>(comment.size())) + comment;
}

}  // namespace isoextract::test
