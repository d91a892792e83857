// Caches where the frames of a text file begin, so that reading all its frames one after another is linear in the size
// of the file.
#pragma once

#include <cstdint>
#include <string>

#include "files/file_bytes.hpp"
#include "files/file_version.hpp"
#include "particle_io/detail/content_reader.hpp"
#include "particle_io/detail/particle_source.hpp"

namespace isoextract::particle_io {

// Keeps the positions for the life of the process, for the last few files and at most 65536 frames of each: of every
// frame, or in long files of every second, fourth, ... one. Recognizes a file by its version; caches nothing for a file
// that was just written to (FileVersion::is_reliable). Safe to use from several threads.
class FrameIndex {
 public:
  // Throws Refused.
  explicit FrameIndex(const files::InputFile& file);

  // Moves the content to the last cached frame up to `wanted` and returns its number; 0 is the start of the content.
  // Sets `carried` to the value that add() got for it; leaves it unchanged at the start.
  std::uint64_t seek_nearest_frame(ContentReader& content, std::uint64_t wanted, std::string& carried) const;

  // Records that frame `number` begins at the content's position; `carried` is state inherited from earlier frames.
  void add(std::uint64_t number, const ContentReader& content, const std::string& carried) const;

 private:
  files::FileVersion file_;
  bool is_settled_ = false;
};

// Counts all frames of a file, starting with number `next`. `pass(number)` skips one frame; it returns false if there
// is none. A truncated last frame counts, as the others can be read.
template <class Pass>
std::uint64_t count_frames(std::uint64_t next, Pass&& pass) {
  try {
    while (pass(next)) ++next;
  } catch (const TruncatedFrame&) {
    ++next;
  }
  return next;
}

// Returns the wanted frame, up to its first particle. `next(frame)` reads up to the first particle of the next frame,
// and returns false if there is none; `skip(frame)` passes its particles. Throws `no_frames`
// if there is no frame at all, and as throw_frame_error() does. For formats without inherited state.
template <class Frame, class Next, class Skip>
Frame find_frame(ContentReader& content, const FrameIndex& index, const ParticleReadOptions& options,
                 const InvalidParticleFile& no_frames, const Next& next, const Skip& skip) {
  const std::uint64_t wanted = wanted_frame(options);
  Frame frame;
  std::string nothing;
  for (std::uint64_t k = index.seek_nearest_frame(content, wanted, nothing);; ++k) {
    index.add(k, content, nothing);
    if (!next(frame)) {
      if (k == 0) throw no_frames;
      throw_frame_error(options, k);
    }
    if (k == wanted) return frame;
    skip(frame);
  }
}

// Goes through the frames from number `next_number` on, and returns how many there are in all; see find_frame().
template <class Frame, class Next, class Skip>
std::uint64_t count_frames_from(std::uint64_t next_number, ContentReader& content, const FrameIndex& index,
                                const Next& next, const Skip& skip) {
  Frame frame;
  return count_frames(next_number, [&](std::uint64_t number) {
    index.add(number, content, {});
    if (!next(frame)) return false;
    skip(frame);
    return true;
  });
}

}  // namespace isoextract::particle_io
