// The bytes of a file that one frame depends on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace isoextract::files {

struct ByteRange {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;

  friend bool operator==(const ByteRange&, const ByteRange&) = default;
};

struct FilePart {
  std::filesystem::path path;
  std::vector<ByteRange> ranges;  // in order; empty: the whole file

  friend bool operator==(const FilePart&, const FilePart&) = default;
};

}  // namespace isoextract::files
