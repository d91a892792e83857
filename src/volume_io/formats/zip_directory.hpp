// The directory of a ZIP file, which is at its end, and where the bytes of its members are (PKWARE, APPNOTE.TXT 6.3.10:
// sections 4.3.7 local file header, 4.3.12 central directory, 4.3.14 to 4.3.16 its end, 4.5.3 ZIP64). No size in it is
// trusted: all is held against the file. Private to the reader of .npz.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "files/file_bytes.hpp"
#include "volume_io/detail/sample_source.hpp"

namespace isoextract::volume_io {

struct ZipMember {
  std::string name;  // as the file has it, which may be any bytes
  int method = 0;    // 0 stored, 8 Deflate
  bool encrypted = false;
  DeflatedMember sizes;
  std::uint64_t header = 0;  // where in the file its local header is
};

// All members, in the order of the directory. Fails with ErrorCode::input where the file has no directory at its end,
// or one that does not fit into it.
[[nodiscard]] Result<std::vector<ZipMember>> read_zip_directory(const files::InputFile& file);

// Its bytes: from their first one on, which content byte 0 is, to their last; packed or as they are. Fails with
// ErrorCode::input where they are encrypted, packed by another method than Deflate, or not within the file.
[[nodiscard]] Result<SamplePiece> locate_zip_member(const files::InputFile& file, const ZipMember& member);

// At most `count` bytes from the start of what `piece`, of a ZIP file, holds; fewer where it holds no more.
[[nodiscard]] Result<std::vector<std::byte>> first_bytes_of(const files::InputFile& file, const SamplePiece& piece,
                                                            std::size_t count);

}  // namespace isoextract::volume_io
