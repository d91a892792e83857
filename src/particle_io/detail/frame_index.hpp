// Caches where the frames of a text file begin, so that reading all its frames one after another is linear in the size
// of the file.
#pragma once

#include <cstdint>
#include <string>

#include "files/file_bytes.hpp"
#include "files/file_part.hpp"
#include "files/file_version.hpp"
#include "particle_io/detail/content_reader.hpp"

namespace isoextract::particle_io {

// State that later frames inherit from a frame, such as units that the file states once.
struct Inherited {
  std::string text;
  files::ByteRange stated;  // where the file states it
};

// Keeps the positions for the life of the process, for the last 4 files. Keeps at most 65,536 positions for each file:
// in files of more frames, the positions of every second, fourth, ... frame. Recognizes a file by its version; caches
// nothing for a file that was just written to (FileVersion::is_reliable). Safe to use from several threads.
class FrameIndex {
 public:
  // Throws Refused.
  explicit FrameIndex(const files::InputFile& file);

  // Moves the content to the last cached frame up to `wanted` and returns its number; 0 is the start of the content.
  // Sets `inherited` to the value that add() got for that frame; leaves it unchanged if no frame is cached.
  std::uint64_t seek_nearest_frame(ContentReader& content, std::uint64_t wanted, Inherited& inherited) const;

  // Records that frame `number` begins at the content's position.
  void add(std::uint64_t number, const ContentReader& content, const Inherited& inherited) const;

 private:
  files::FileVersion file_;
  bool is_settled_ = false;
};

}  // namespace isoextract::particle_io
