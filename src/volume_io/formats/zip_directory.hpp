// Reads the directory at the end of a ZIP file and locates its members (PKWARE, APPNOTE.TXT 6.3.10: sections 4.3.7
// local file header, 4.3.12 central directory, 4.3.14 to 4.3.16 its end, 4.5.3 ZIP64). Validates all sizes against the
// file. Private to the .npz reader.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "files/file_bytes.hpp"
#include "volume_io/detail/sample_source.hpp"

namespace isoextract::volume_io {

struct ZipMember {
  std::string name;  // as in the file; may be any bytes
  int method = 0;    // 0 stored, 8 Deflate
  bool encrypted = false;
  DeflatedMember sizes;
  std::uint64_t header = 0;  // position of its local header in the file
};

// Returns all members in the order of the directory. Fails with ErrorCode::input if there is no directory at the end of
// the file, or if it is damaged, larger than 64 MiB or not within the file.
[[nodiscard]] Result<std::vector<ZipMember>> read_zip_directory(const files::InputFile& file);

// Returns the range of the member's bytes, stored or compressed; it starts with the content's first byte. Fails with
// ErrorCode::input if they are encrypted, compressed by another method than Deflate, or not within the file.
[[nodiscard]] Result<SamplePiece> find_member_bytes(const files::InputFile& file, const ZipMember& member);

// Returns the first bytes of the content of `piece`, at most `count`; fewer if the content is shorter.
[[nodiscard]] Result<std::vector<std::byte>> first_bytes_of(const files::InputFile& file, const SamplePiece& piece,
                                                            std::size_t count);

}  // namespace isoextract::volume_io
