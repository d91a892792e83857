// Where the frames of a text file begin, as far as earlier readings of the same file came, so that reading all of its
// frames, one after the other, goes through it once and not once for each.
#pragma once

#include <cstdint>
#include <string>

#include "files/file_bytes.hpp"
#include "files/file_version.hpp"
#include "particle_io/detail/content_reader.hpp"
#include "particle_io/detail/particle_source.hpp"

namespace isoextract::particle_io {

// Places are kept for the process, of the last few files and at most 65536 of each: of every frame, or in long files of
// every second, fourth, ... one. A file is known again by its version; nothing is kept of one that was written to just
// now (FileVersion::is_settled). Safe to use from several threads.
class FrameIndex {
 public:
  // Throws Refused.
  explicit FrameIndex(const files::InputFile& file);

  // Moves the content to the last known frame up to `wanted` and returns its number: 0 at the start of the content.
  // `carried` becomes what add() was given with it, and stays as it is at the start.
  std::uint64_t go_to_nearest(ContentReader& content, std::uint64_t wanted, std::string& carried) const;

  // Notes that frame `number` begins where the content is; `carried` is what it takes over from the frames before it.
  void add(std::uint64_t number, const ContentReader& content, const std::string& carried) const;

 private:
  files::FileVersion file_;
  bool is_settled_ = false;
};

// Goes through the frames from number `next` on and returns how many there are in all. `pass(number)` reads past one,
// and is false where there is none. The last one counts where it is cut short: those before it can be read.
template <class Pass>
std::uint64_t count_frames(std::uint64_t next, Pass&& pass) {
  try {
    while (pass(next)) ++next;
  } catch (const CutShort&) {
    ++next;
  }
  return next;
}

}  // namespace isoextract::particle_io
