// Walks through the frames of a text file. A format gives a type `Frames` with these members:
//   Frame        the header of a frame. Its members: `begin`, the position of its first byte in the content;
//                `inherited`, an Inherited; `time`, a FrameTime
//   no_frames()  the error of a file without frames, an InvalidParticleFile
//   kEndsInRow   whether the last line of a frame has values that a missing line end could make incomplete
//   next(content, frame)   reads up to the first particle of the next frame; returns false if there is none. `frame` is
//                          the one before, or only has `inherited`
//   skip(content, frame)   passes the particles of the frame
// next() and skip() throw TruncatedFrame if the file ends within the frame.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/note.hpp"
#include "files/file_bytes.hpp"
#include "particle_io/detail/content_reader.hpp"
#include "particle_io/detail/frame_index.hpp"
#include "particle_io/detail/particle_source.hpp"

namespace isoextract::particle_io {

// Returns the wanted frame, up to its first particle. Throws TruncatedFrame if it or the first frame is incomplete,
// no_frames() if the file has no frames, and as throw_frame_error() does if the wanted frame does not exist.
template <class Frames>
typename Frames::Frame find_frame(ContentReader& content, const FrameIndex& index, const ParticleReadOptions& options) {
  const std::uint64_t wanted = wanted_frame(options);
  typename Frames::Frame frame;
  std::uint64_t k = index.seek_nearest_frame(content, wanted, frame.inherited);
  try {
    for (;; ++k) {
      index.add(k, content, frame.inherited);
      if (!Frames::next(content, frame)) break;
      if (k == wanted) return frame;
      Frames::skip(content, frame);
    }
  } catch (const TruncatedFrame&) {
    if (k == 0 || k == wanted) throw;
  }
  if (k == 0) throw Frames::no_frames();
  throw_frame_error(options, k);
}

// Returns the step and the time of the wanted frame; throws as find_frame() does.
template <class Frames>
FrameTime find_time(const files::InputFile& file, const ParticleReadOptions& options) {
  ContentReader content(file);
  return find_frame<Frames>(content, FrameIndex(file), options).time;
}

// Returns the bytes that the selected frame depends on: the frame's bytes, and the bytes of the state that it inherits.
// Returns nothing if the options select no frame, and for compressed files.
template <class Frames>
std::vector<files::ByteRange> find_ranges(const files::InputFile& file, const ParticleReadOptions& options) {
  ContentReader content(file);
  if (!options.frame || content.is_compressed()) return {};
  const FrameIndex index(file);
  typename Frames::Frame frame = find_frame<Frames>(content, index, options);
  Frames::skip(content, frame);
  index.add(wanted_frame(options) + 1, content, frame.inherited);
  std::vector<files::ByteRange> ranges{{frame.begin, content.position() - frame.begin}};
  const files::ByteRange& stated = frame.inherited.stated;
  if (stated.bytes > 0 && stated.offset < frame.begin) ranges.insert(ranges.begin(), stated);
  return ranges;
}

struct FrameCount {
  std::uint64_t frames = 0;           // number of whole frames in the file
  std::optional<TruncatedFrame> cut;  // set if an incomplete frame follows the whole frames
  Notes notes;                        // about the end of the file
};

// Returns the note that the last frame of a file, number `frames`, is incomplete.
[[nodiscard]] Note incomplete_frame_note(const std::string& file, std::uint64_t frames, const TruncatedFrame& cut);
// Returns the note that the last frame, number `last`, may be incomplete, as the last line of the file has no line end.
[[nodiscard]] Note open_line_note(const std::string& file, std::uint64_t last);

// Counts all frames of a file, of which the caller has read the first `next`; `frame` is the last of these. Calls
// seen(number, frame) for each whole frame from `next` on. Throws TruncatedFrame only if there is no whole frame.
template <class Frames, class Seen>
FrameCount count_frames(const files::InputFile& file, ContentReader& content, const FrameIndex& index,
                        std::uint64_t next, typename Frames::Frame frame, const Seen& seen) {
  FrameCount count{next, {}, {}};
  try {
    for (;; ++count.frames) {
      index.add(count.frames, content, frame.inherited);
      if (!Frames::next(content, frame)) break;
      Frames::skip(content, frame);
      seen(count.frames, frame);
    }
    const bool may_be_cut = Frames::kEndsInRow && count.frames > 1 && !content.line_has_end();
    if (may_be_cut) count.notes.push_back(open_line_note(file.name(), count.frames - 1));
  } catch (const TruncatedFrame& cut) {
    if (count.frames == 0) throw;
    count.cut = cut;
    count.notes.push_back(incomplete_frame_note(file.name(), count.frames, cut));
  }
  return count;
}

// Throws as throw_frame_error() does if the file has a second whole frame and the options select no frame. Call after
// reading `frame`, the first. Returns notes about the end of the file.
template <class Frames>
Notes check_only_frame(const files::InputFile& file, ContentReader& content, const FrameIndex& index,
                       const ParticleReadOptions& options, const typename Frames::Frame& frame) {
  if (options.frame) return {};
  FrameCount count = count_frames<Frames>(file, content, index, 1, frame, [](std::uint64_t, const auto&) {});
  if (count.frames > 1) throw_frame_error(options, count.frames);
  return std::move(count.notes);
}

// Fills frames, times and notes of `info` from all frames of the file. Returns the wanted frame; throws as find_frame()
// does.
template <class Frames>
typename Frames::Frame survey_frames(const files::InputFile& file, const ParticleReadOptions& options,
                                     ParticleInfo& info) {
  const std::uint64_t wanted = wanted_frame(options);
  ContentReader content(file);
  const FrameIndex index(file);
  std::optional<typename Frames::Frame> chosen;
  FrameCount count = count_frames<Frames>(file, content, index, 0, {}, [&](std::uint64_t k, const auto& frame) {
    info.times.push_back(frame.time);
    if (k == wanted) chosen = frame;
  });
  if (count.frames == 0) throw Frames::no_frames();
  if (!chosen && count.cut && wanted == count.frames) throw TruncatedFrame(*count.cut);
  if (!chosen) throw_frame_error(options, count.frames);
  info.frames = count.frames;
  info.notes = std::move(count.notes);
  return std::move(*chosen);
}

}  // namespace isoextract::particle_io
