// Segmentation objects (PS3.3, C.8.20): each frame is the mask of one segment in one slice.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "dicom_dataset.hpp"

namespace isoextract_dicom {

using isoextract_plugin::Grid;

void read_segments(const gdcm::DataSet& data, const std::string& character_set, Object& object) {
  const std::string type = text_of(data, gdcm::Tag(0x0062, 0x0001));
  if (type.empty()) return;
  object.segmentation = type == "BINARY"       ? Segmentation::binary
                        : type == "FRACTIONAL" ? Segmentation::fractional
                        : type == "LABELMAP"   ? Segmentation::label_map
                                               : Segmentation::none;
  if (object.segmentation == Segmentation::none) {
    throw ReadError("expected a segmentation of type BINARY, FRACTIONAL or LABELMAP, found " + type);
  }
  object.segments_are_disjoint = text_of(data, gdcm::Tag(0x0062, 0x0013)) == "NO";
  if (object.segmentation == Segmentation::fractional)
    object.full_fraction = std::max(1U, uint16_of(data, gdcm::Tag(0x0062, 0x000e)).value_or(255));
  const Items items(data, gdcm::Tag(0x0062, 0x0002));
  for (std::size_t i = 0; i < items.size(); ++i) {
    Segment segment;
    segment.number = uint16_of(items[i], gdcm::Tag(0x0062, 0x0004)).value_or(static_cast<std::uint32_t>(i + 1));
    segment.label.value = segment.number;
    segment.label.name = text_of(items[i], gdcm::Tag(0x0062, 0x0005), character_set);
    if (const auto lab = uint16s_of(items[i], gdcm::Tag(0x0062, 0x000d)); lab.size() == 3) {
      segment.label.color = srgb_of_dicom_lab({double(lab[0]), double(lab[1]), double(lab[2])});
      segment.label.has_color = true;
    }
    const auto has_number = [&](const Segment& other) { return other.number == segment.number; };
    if (std::ranges::any_of(object.segments, has_number))
      throw ReadError("expected segments with different numbers, found " + std::to_string(segment.number) + " twice");
    object.segments.push_back(std::move(segment));
  }
  if (object.segments.empty()) throw ReadError("expected a segmentation with segments, found none");
}

SegmentationGrids::SegmentationGrids(std::shared_ptr<const Object> object, const isoextract_plugin_host& host)
    : object_(std::move(object)) {
  if (!object_->problem.empty()) throw ReadError(object_->problem);
  if (object_->pixels.samples_per_pixel != 1) {
    throw ReadError("expected one sample per pixel of a segmentation, found " +
                    std::to_string(object_->pixels.samples_per_pixel));
  }
  const std::int32_t type = sample_type(object_->pixels);
  const bool is_label_map = object_->segmentation == Segmentation::label_map;
  if (type != ISOEXTRACT_U8 && !(is_label_map && type == ISOEXTRACT_U16)) {
    throw ReadError("expected masks of 1 or 8 bits per pixel, or labels of 8 or 16, found " +
                    std::to_string(object_->pixels.bits_allocated) + " bits");
  }
  place_frames();
  add_grids(layers(host));
}

// Slices without any segment may be left out, so positions are multiples of the distance between slices.
void SegmentationGrids::place_frames() {
  const Frame& shape = object_->frames.front();
  const bool has_frame_segments = object_->segmentation != Segmentation::label_map;
  for (const Frame& frame : object_->frames) {
    if (!frame.has_position || !frame.has_orientation)
      throw ReadError("expected frames of a segmentation with positions and orientations, found a frame without them");
    if (!same_shape(frame, shape))
      throw ReadError("expected frames of a segmentation with one orientation and pixel spacing, found several");
  }
  const Vector normal = normal_of(shape);
  const auto along = [&](const Frame& frame) { return dot(frame.position, normal); };
  std::vector<std::pair<double, Vector>> places;
  for (const Frame& frame : object_->frames) places.emplace_back(along(frame), frame.position);
  std::ranges::sort(places);
  const double same = 0.01 * std::min(shape.column_distance, shape.row_distance);
  double distance = std::numeric_limits<double>::infinity();
  double last = places.front().first;
  for (const auto& [at, position] : places) {
    if (at - last > same) distance = std::min(distance, at - last);
    if (at - last > same || at == places.front().first) last = at;
  }
  const double stated = shape.slice_distance;
  const bool is_multiple = stated > same && std::abs(distance / stated - std::round(distance / stated)) < 0.02;
  if (!std::isfinite(distance)) {
    step_ = fit_line({shape.position}, shape, false).step;
  } else {
    if (is_multiple) distance = stated;
    const double whole = places.back().first - places.front().first;
    const double intervals = std::round(whole / distance);
    step_ = plus({0, 0, 0}, minus(places.back().second, places.front().second), 1 / intervals);
  }
  origin_ = places.front().second;
  const double step_along = dot(step_, normal);
  for (const Frame& frame : object_->frames) {
    const double number = std::round((along(frame) - places.front().first) / step_along);
    const Vector expected = plus(origin_, step_, number);
    constexpr double kMostSlices = 1 << 20;
    if (length(minus(frame.position, expected)) > std::max(0.02 * step_along, same) || number > kMostSlices) {
      throw ReadError("expected frames of a segmentation at multiples of " + number_text(step_along) +
                      " mm, found one " + number_text(along(frame) - places.front().first) + " mm from the first");
    }
    const auto segment = std::ranges::find(object_->segments, frame.segment, &Segment::number);
    if (has_frame_segments && segment == object_->segments.end())
      throw ReadError("expected frames of the listed segments, found one of segment " + std::to_string(frame.segment));
    const auto place = has_frame_segments ? segment - object_->segments.begin() : 0;
    frames_.push_back({frame.index, static_cast<std::uint32_t>(place), static_cast<std::uint64_t>(number)});
    slices_ = std::max(slices_, frames_.back().slice + 1);
  }
  std::ranges::stable_sort(frames_, {}, [](const Placed& placed) { return placed.slice; });
}

namespace {

// A mask with one bit per pixel. All set pixels are in words[first, end).
struct Mask {
  std::vector<std::uint64_t> words;
  std::size_t first = 0, end = 0;

  Mask(const std::vector<std::byte>& pixels, double threshold) : words((pixels.size() + 63) / 64) {
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (std::to_integer<unsigned>(pixels[i]) > threshold) words[i / 64] |= std::uint64_t{1} << (i % 64);
    }
    while (first < words.size() && words[first] == 0) ++first;
    end = words.size();
    while (end > first && words[end - 1] == 0) --end;
  }
  [[nodiscard]] bool overlaps(const Mask& other) const {
    for (std::size_t i = std::max(first, other.first); i < std::min(end, other.end); ++i) {
      if ((words[i] & other.words[i]) != 0) return true;
    }
    return false;
  }
};

// A pixel of a mask is set if its fraction is more than a half.
double threshold_of(const Object& object) {
  return object.segmentation == Segmentation::fractional ? object.full_fraction / 2 : 0;
}

}  // namespace

// Distributes the segments to layers, each to the first layer whose segments it does not overlap.
std::vector<std::vector<std::uint32_t>> SegmentationGrids::layers(const isoextract_plugin_host& host) const {
  const std::size_t count = object_->segments.size();
  std::vector<std::uint32_t> all(count);
  std::iota(all.begin(), all.end(), 0U);
  if (object_->segmentation == Segmentation::label_map || object_->segments_are_disjoint || count == 1) return {all};

  std::vector<std::set<std::uint32_t>> overlapped(count);
  isoextract_plugin::HostMemory memory(host);
  memory.take(object_->pixels.samples() * 2);
  PixelReader reader(object_->pixels);
  for (std::size_t first = 0; first < frames_.size();) {
    isoextract_plugin::check_cancelled(host);
    std::size_t end = first;
    while (end < frames_.size() && frames_[end].slice == frames_[first].slice) ++end;
    isoextract_plugin::HostMemory masks_memory(host);
    masks_memory.take((end - first) * (object_->pixels.samples() / 8 + 8));
    std::vector<Mask> masks;
    for (std::size_t i = first; i < end; ++i) {
      masks.emplace_back(reader.frame(frames_[i].frame), threshold_of(*object_));
      for (std::size_t j = first; j < i; ++j) {
        const std::uint32_t a = frames_[i].segment;
        const std::uint32_t b = frames_[j].segment;
        if (a == b || overlapped[a].contains(b) || !masks.back().overlaps(masks[j - first])) continue;
        overlapped[a].insert(b);
        overlapped[b].insert(a);
      }
    }
    first = end;
  }
  std::vector<std::vector<std::uint32_t>> layers;
  for (const std::uint32_t segment : all) {
    const auto fits = [&](const std::vector<std::uint32_t>& layer) {
      return std::ranges::none_of(layer, [&](std::uint32_t other) { return overlapped[segment].contains(other); });
    };
    auto layer = std::ranges::find_if(layers, fits);
    if (layer == layers.end()) layer = layers.insert(layers.end(), std::vector<std::uint32_t>());
    layer->push_back(segment);
  }
  return layers;
}

void SegmentationGrids::add_grids(const std::vector<std::vector<std::uint32_t>>& layers) {
  const Object& object = *object_;
  Grid common;
  common.world_space = "left-posterior-superior";
  common.length_unit = "mm";
  common.dims = {object.pixels.columns, object.pixels.rows, slices_};
  common.index_to_world = index_to_world(object.frames.front(), origin_, step_);
  const std::string name = series_name(object);
  for (const std::vector<std::uint32_t>& layer : layers) {
    Grid grid = common;
    grid.name = name;
    if (layers.size() > 1) grid.name += " layer " + std::to_string(grids.size() + 1);
    std::uint32_t largest = 0;
    for (const std::uint32_t segment : layer) {
      grid.labels.push_back(object.segments[segment].label);
      largest = std::max(largest, object.segments[segment].number);
    }
    grid.sample_type = largest < 256 ? ISOEXTRACT_U8 : ISOEXTRACT_U16;
    if (object.segmentation == Segmentation::label_map) grid.sample_type = sample_type(object.pixels);
    grid.type_name = grid.sample_type == ISOEXTRACT_U8 ? "uint8 labels" : "uint16 labels";
    grids.push_back(std::move(grid));
    grid_segments_.push_back(layer);
  }
  label_map_count_ = grids.size();
  if (layers.size() > 1)
    note = "segments overlap, so the reader makes label maps of them in " + std::to_string(layers.size()) + " grids";
  if (object.segmentation != Segmentation::fractional) return;
  for (std::uint32_t segment = 0; segment < object.segments.size(); ++segment) {
    Grid grid = common;
    grid.name = object.segments[segment].label.name + " fraction";
    grid.sample_type = sample_type(object.pixels);
    grid.type_name = "uint8 fractions";
    grid.slope = 1 / object.full_fraction;
    grids.push_back(std::move(grid));
    grid_segments_.push_back({segment});
  }
}

isoextract_plugin::ReadFacts SegmentationGrids::read(std::size_t index, const isoextract_volume_selection& selection,
                                                     const isoextract_plugin_host& host) const {
  const Grid& grid = grids[index];
  const auto& segments = grid_segments_[index];
  const bool copies = index >= label_map_count_ || object_->segmentation == Segmentation::label_map;
  const bool is_label_map = object_->segmentation == Segmentation::label_map;
  const std::uint64_t samples = selection.count[0] * selection.count[1] * selection.count[2];
  std::memset(selection.box, 0,
              samples * isoextract_plugin::sample_size(isoextract_plugin::selected_type(grid, selection)));
  isoextract_plugin::HostMemory memory(host);
  memory.take(object_->pixels.samples() * 2);
  PixelReader reader(object_->pixels);
  isoextract_plugin::ReadFacts facts;
  facts.parts = frames_.size();
  const double threshold = threshold_of(*object_);
  for (const Placed& placed : frames_) {
    const bool is_wanted = is_label_map || std::ranges::find(segments, placed.segment) != segments.end();
    if (!is_wanted || placed.slice < selection.first[2] || placed.slice >= selection.first[2] + selection.count[2])
      continue;
    isoextract_plugin::check_cancelled(host);
    ++facts.parts_read;
    const std::vector<std::byte>& pixels = reader.frame(placed.frame);
    const std::uint64_t slice = placed.slice - selection.first[2];
    isoextract_plugin::with_sample_type(grid.sample_type, [&]<class T>(T) {
      T* to = static_cast<T*>(selection.box) + slice * selection.count[0] * selection.count[1];
      const T label = static_cast<T>(object_->segments[placed.segment].number);
      for (std::uint64_t y = 0; y < selection.count[1]; ++y) {
        const std::uint64_t row = (selection.first[1] + y) * object_->pixels.columns + selection.first[0];
        for (std::uint64_t x = 0; x < selection.count[0]; ++x, ++to) {
          if (copies) {
            std::memcpy(to, pixels.data() + (row + x) * sizeof(T), sizeof(T));
          } else if (std::to_integer<unsigned>(pixels[row + x]) > threshold) {
            *to = label;
          }
        }
      }
    });
  }
  return facts;
}

}  // namespace isoextract_dicom
