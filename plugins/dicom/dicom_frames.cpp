// Position, scale and sort keys of an object's frames.
#include <algorithm>
#include <charconv>
#include <cmath>

#include "dicom_dataset.hpp"

namespace isoextract_dicom {
namespace {

using gdcm::DataSet;
using gdcm::Tag;

std::string key_text(const std::optional<double>& value) { return value ? number_text(*value) : std::string(); }

// Reads the position from an object's data set or an item of a functional group, as the next three functions do.
void read_position(const DataSet& data, Frame& frame) {
  const auto values = decimals_of(data, Tag(0x0020, 0x0032));
  if (values.size() != 3) return;
  std::copy_n(values.begin(), 3, frame.position.begin());
  frame.has_position = true;
}

void read_orientation(const DataSet& data, Frame& frame) {
  const auto values = decimals_of(data, Tag(0x0020, 0x0037));
  if (values.size() != 6) return;
  std::copy_n(values.begin(), 3, frame.row_direction.begin());
  std::copy_n(values.begin() + 3, 3, frame.column_direction.begin());
  const auto is_unit = [](const Vector& v) { return std::abs(length(v) - 1) < 0.01; };
  // Tolerates direction cosines that are rounded in the header.
  frame.has_orientation = is_unit(frame.row_direction) && is_unit(frame.column_direction) &&
                          std::abs(dot(frame.row_direction, frame.column_direction)) < 0.01;
}

void read_distances(const DataSet& data, Frame& frame) {
  const auto spacing = decimals_of(data, Tag(0x0028, 0x0030));
  if (spacing.size() == 2 && spacing[0] > 0 && spacing[1] > 0) {
    frame.row_distance = spacing[0];
    frame.column_distance = spacing[1];
    frame.has_spacing = true;
  }
  frame.thickness = decimal_of(data, Tag(0x0018, 0x0050)).value_or(frame.thickness);
  frame.slice_distance = decimal_of(data, Tag(0x0018, 0x0088)).value_or(frame.slice_distance);
}

void read_scale(const DataSet& data, Frame& frame) {
  const auto slope = decimal_of(data, Tag(0x0028, 0x1053));
  // Some devices write the slope 0 for images without a slope.
  if (slope && *slope != 0) frame.slope = *slope;
  frame.intercept = decimal_of(data, Tag(0x0028, 0x1052)).value_or(frame.intercept);
}

void read_keys(const DataSet& data, Frame& frame) {
  const auto set = [&](Key key, std::string text) { frame.keys[static_cast<std::size_t>(key)] = std::move(text); };
  const auto decimal = [&](std::uint16_t group, std::uint16_t element) {
    return key_text(decimal_of(data, Tag(group, element)));
  };
  set(Key::image_type, text_of(data, Tag(0x0008, 0x0008)));
  set(Key::temporal_position, decimal(0x0020, 0x0100));
  set(Key::trigger_time, decimal(0x0018, 0x1060));
  set(Key::reference_time, decimal(0x0054, 0x1300));
  set(Key::echo_number, decimal(0x0018, 0x0086));
  set(Key::echo_time, decimal(0x0018, 0x0081));
  set(Key::b_value, key_text(double_of(data, Tag(0x0018, 0x9087))));
  set(Key::acquisition_number, decimal(0x0020, 0x0012));
  set(Key::acquisition_time, key_text(seconds_of(text_of(data, Tag(0x0008, 0x0032)))));
}

// The functional groups of one frame: per-frame groups, else the shared ones.
class Groups {
 public:
  Groups(const DataSet* own, const DataSet* shared) : sets_{own, shared} {}

  // Calls use(data) with the first item of a group, if the frame has the group.
  template <class Use>
  void with(const Tag& group, Use&& use) const {
    for (const DataSet* const set : sets_) {
      if (set == nullptr) continue;
      const Items items(*set, group);
      if (items.size() == 0) continue;
      use(items[0]);
      return;
    }
  }

 private:
  std::array<const DataSet*, 2> sets_;
};

void read_groups(const Groups& groups, Frame& frame) {
  const auto set = [&](Key key, std::string text) {
    if (!text.empty()) frame.keys[static_cast<std::size_t>(key)] = std::move(text);
  };
  groups.with(Tag(0x0020, 0x9113), [&](const DataSet& data) { read_position(data, frame); });
  groups.with(Tag(0x0020, 0x9116), [&](const DataSet& data) { read_orientation(data, frame); });
  groups.with(Tag(0x0028, 0x9110), [&](const DataSet& data) { read_distances(data, frame); });
  groups.with(Tag(0x0028, 0x9145), [&](const DataSet& data) { read_scale(data, frame); });
  groups.with(Tag(0x0020, 0x9111), [&](const DataSet& data) {
    frame.stack = text_of(data, Tag(0x0020, 0x9056));
    if (const auto index = uint32_of(data, Tag(0x0020, 0x9128))) set(Key::temporal_position, std::to_string(*index));
    set(Key::acquisition_number, key_text(uint16_of(data, Tag(0x0020, 0x9156))));
    set(Key::acquisition_time, key_text(seconds_of(text_of(data, Tag(0x0018, 0x9074)))));
  });
  for (const Tag& type : {Tag(0x0018, 0x9226), Tag(0x0018, 0x9329)}) {  // of MR, of CT
    groups.with(type, [&](const DataSet& data) { set(Key::image_type, text_of(data, Tag(0x0008, 0x9007))); });
  }
  groups.with(Tag(0x0018, 0x9118),
              [&](const DataSet& data) { set(Key::trigger_time, key_text(double_of(data, Tag(0x0020, 0x9153)))); });
  groups.with(Tag(0x0020, 0x9310), [&](const DataSet& data) {
    if (const auto seconds = double_of(data, Tag(0x0020, 0x930d)))
      set(Key::reference_time, number_text(*seconds * 1000));
  });
  groups.with(Tag(0x0018, 0x9114),
              [&](const DataSet& data) { set(Key::echo_time, key_text(double_of(data, Tag(0x0018, 0x9082)))); });
  groups.with(Tag(0x0018, 0x9117),
              [&](const DataSet& data) { set(Key::b_value, key_text(double_of(data, Tag(0x0018, 0x9087)))); });
  groups.with(Tag(0x0062, 0x000a),
              [&](const DataSet& data) { frame.segment = uint16_of(data, Tag(0x0062, 0x000b)).value_or(0); });
}

// Places the frames of an object without functional groups: by offsets (RT dose), else by the distance between slices.
void stack_frames(const DataSet& data, Object& object) {
  const auto offsets = decimals_of(data, Tag(0x3004, 0x000c));
  for (Frame& frame : object.frames) {
    if (!frame.has_position || !frame.has_orientation) continue;
    const bool has_offsets = offsets.size() == object.frames.size();
    if (!has_offsets && frame.slice_distance == 0) {
      frame.has_position = false;
      continue;
    }
    const double distance = has_offsets ? offsets[frame.index] - offsets[0] : frame.index * frame.slice_distance;
    frame.position = plus(frame.position, normal_of(frame), distance);
    object.is_stacked = !has_offsets;
  }
}

}  // namespace

std::string number_text(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 6).ptr;
  return {text.data(), end};
}

void read_frames(const DataSet& data, Object& object) {
  Frame first;
  read_position(data, first);
  read_orientation(data, first);
  read_distances(data, first);
  read_scale(data, first);
  read_keys(data, first);
  if (const auto dose = decimal_of(data, Tag(0x3004, 0x000e)); dose && *dose > 0) first.slope = *dose;
  const Items detectors(data, Tag(0x0054, 0x0022));  // nuclear medicine
  if (detectors.size() > 0) {
    read_position(detectors[0], first);
    read_orientation(detectors[0], first);
  }

  const Items own(data, Tag(0x5200, 0x9230));
  const Items shared(data, Tag(0x5200, 0x9229));
  const bool has_groups = own.size() > 0 || shared.size() > 0;
  const std::uint32_t count = object.pixels.frames;
  if (own.size() > 0 && own.size() != count) {
    throw ReadError("expected functional groups of " + std::to_string(count) + " frames, found " +
                    std::to_string(own.size()));
  }
  object.frames.assign(count, first);
  for (std::uint32_t i = 0; i < count; ++i) {
    Frame& frame = object.frames[i];
    frame.index = i;
    read_groups(Groups(own.size() > 0 ? &own[i] : nullptr, shared.size() > 0 ? &shared[0] : nullptr), frame);
  }
  if (!has_groups && count > 1) stack_frames(data, object);
}

}  // namespace isoextract_dicom
