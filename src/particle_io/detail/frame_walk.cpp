#include "particle_io/detail/frame_walk.hpp"

#include <fmt/format.h>

#include "base/printable.hpp"

namespace isoextract::particle_io {

Note incomplete_frame_note(const std::string& file, std::uint64_t frames, const TruncatedFrame& cut) {
  const std::string before = frames == 1 ? "frame" : fmt::format("{} frames", frames);
  return {NoteId::incomplete_frame,
          fmt::format("the last frame ({}) of {} is incomplete: {}; the reader uses the {} before it", frames,
                      printable(file), cut.found, before)};
}

Note open_line_note(const std::string& file, std::uint64_t last) {
  return {
      NoteId::incomplete_frame,
      fmt::format("the last line of {} has no line end; if a program still writes the file, the last frame ({}) may "
                  "be incomplete",
                  printable(file), last)};
}

}  // namespace isoextract::particle_io
