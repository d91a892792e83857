#include "particle_io/detail/frame_index.hpp"

#include <algorithm>
#include <mutex>
#include <utility>
#include <vector>

namespace isoextract::particle_io {
namespace {

constexpr std::size_t kMostPlaces = 65536;
constexpr std::size_t kMostFiles = 4;

struct FramePlace {
  LineStart at;
  Inherited inherited;
};

// Positions of the frames 0, stride, 2 stride, ...
struct FramePlaces {
  std::uint64_t stride = 1;
  std::vector<FramePlace> places;

  void add(std::uint64_t number, FramePlace place) {
    if (places.size() == kMostPlaces) {
      for (std::size_t i = 1; 2 * i < places.size(); ++i) places[i] = std::move(places[2 * i]);
      places.resize(places.size() / 2);
      stride *= 2;
    }
    if (number == places.size() * stride) places.push_back(std::move(place));
  }
};

struct Store {
  std::mutex mutex;
  std::vector<std::pair<files::FileVersion, FramePlaces>> files;  // the most recently used one is last

  FramePlaces& of(const files::FileVersion& file) {
    const auto found = std::ranges::find(files, file, &std::pair<files::FileVersion, FramePlaces>::first);
    if (found != files.end()) {
      std::rotate(found, found + 1, files.end());
    } else {
      if (files.size() == kMostFiles) files.erase(files.begin());
      files.emplace_back(file, FramePlaces());
    }
    return files.back().second;
  }
};

Store& store() {
  static Store known;
  return known;
}

}  // namespace

FrameIndex::FrameIndex(const files::InputFile& file)
    : file_(must(files::version_of(file))), is_settled_(file_.is_reliable()) {}

std::uint64_t FrameIndex::seek_nearest_frame(ContentReader& content, std::uint64_t wanted, Inherited& inherited) const {
  if (!is_settled_) return 0;
  const std::lock_guard lock(store().mutex);
  const FramePlaces& known = store().of(file_);
  if (known.places.empty()) return 0;
  const std::size_t i = std::min<std::uint64_t>(wanted / known.stride, known.places.size() - 1);
  const FramePlace& place = known.places[i];
  // Expects the bytes up to the next known frame or, for the last known frame, from the previous known frame.
  const std::size_t measured = i + 1 < known.places.size() ? i + 1 : i;
  content.go_to(place.at,
                measured == 0 ? 0 : known.places[measured].at.position - known.places[measured - 1].at.position);
  inherited = place.inherited;
  return i * known.stride;
}

void FrameIndex::add(std::uint64_t number, const ContentReader& content, const Inherited& inherited) const {
  if (!is_settled_) return;
  const std::lock_guard lock(store().mutex);
  store().of(file_).add(number, {content.next_line_start(), inherited});
}

}  // namespace isoextract::particle_io
