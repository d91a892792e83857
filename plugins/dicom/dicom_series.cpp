// Sorts slices into series and volumes.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "dicom_parts.hpp"

namespace isoextract_dicom {
namespace {

using Slices = std::vector<Slice>;

// Name of a key in reports, and what its values split a series into.
struct KeyWords {
  Key key;
  const char* name;
  bool makes_volumes;
  bool makes_grids;   // if parts with different key values have different slice positions
  double to_seconds;  // factor; 0: the key is no time
};
constexpr std::array<KeyWords, 9> kKeys{{
    {Key::image_type, "image type", false, true, 0},
    {Key::temporal_position, "temporal position", true, true, 0},
    {Key::trigger_time, "trigger time in ms", true, false, 1e-3},
    {Key::reference_time, "frame reference time in ms", true, false, 1e-3},
    {Key::echo_number, "echo number", true, true, 0},
    {Key::echo_time, "echo time in ms", true, true, 0},
    {Key::b_value, "b value", true, true, 0},
    {Key::acquisition_number, "acquisition", true, true, 0},
    {Key::acquisition_time, "acquisition time", true, false, 1},
}};
static_assert(kKeys.size() == static_cast<std::size_t>(Key::count));

double number_of(const std::string& text) {
  double value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

std::string type_name(std::int32_t type) {
  switch (type) {
    case ISOEXTRACT_U8: return "uint8";
    case ISOEXTRACT_I8: return "int8";
    case ISOEXTRACT_U16: return "uint16";
    case ISOEXTRACT_I16: return "int16";
    case ISOEXTRACT_U32: return "uint32";
    case ISOEXTRACT_I32: return "int32";
    case ISOEXTRACT_F32: return "float";
    case ISOEXTRACT_F64: return "double";
    default: return "pixels of an unknown form";
  }
}

bool is_placed(const Frame& frame) { return frame.has_position && frame.has_orientation; }

double along_normal(const Slice& slice, const Vector& normal) { return dot(slice.frame.position, normal); }

// Numbers the positions of sorted slices along the normal from 0; slices at the same position have the same number.
std::vector<std::size_t> position_numbers(const Slices& slices, const Vector& normal) {
  const Frame& shape = slices.front().frame;
  const double same = 0.01 * std::min(shape.column_distance, shape.row_distance);
  std::vector<std::size_t> numbers;
  double last = 0;
  for (const Slice& slice : slices) {
    const double at = along_normal(slice, normal);
    if (numbers.empty()) {
      numbers.push_back(0);
    } else {
      numbers.push_back(numbers.back() + (at - last > same ? 1 : 0));
    }
    if (numbers.size() == 1 || numbers[numbers.size() - 2] != numbers.back()) last = at;
  }
  return numbers;
}

bool are_distinct(const std::vector<std::size_t>& sorted) { return std::ranges::adjacent_find(sorted) == sorted.end(); }

struct Part {
  std::string value;  // of the key
  Slices slices;
  std::vector<std::size_t> positions;
};

// Splits slices by a key; sorts the parts by the key's value.
std::vector<Part> split_by(const Slices& slices, const std::vector<std::size_t>& positions, Key key) {
  const auto before = [&](const std::string& a, const std::string& b) {
    const double x = number_of(a);
    const double y = number_of(b);
    return x != y ? x < y : a < b;
  };
  std::map<std::string, Part, decltype(before)> parts(before);
  for (std::size_t i = 0; i < slices.size(); ++i) {
    Part& part = parts[slices[i].frame.key(key)];
    part.value = slices[i].frame.key(key);
    part.slices.push_back(slices[i]);
    part.positions.push_back(positions[i]);
  }
  std::vector<Part> found;
  for (auto& [value, part] : parts) found.push_back(std::move(part));
  return found;
}

// Splits the slices of one shape until no two slices of a volume have the same position.
class Splitter {
 public:
  Splitter(bool resamples, std::vector<Series>& series) : resamples_(resamples), series_(series) {}

  void split(Slices slices, const std::string& suffix) {
    const Vector normal = normal_of(slices.front().frame);
    std::ranges::stable_sort(slices, {}, [&](const Slice& slice) {
      return std::pair(along_normal(slice, normal), slice.object->instance_number);
    });
    const auto positions = position_numbers(slices, normal);
    if (are_distinct(positions)) {
      add({std::move(slices)}, suffix, {}, {}, {});
      return;
    }
    for (const KeyWords& words : kKeys) {
      auto parts = split_by(slices, positions, words.key);
      const bool fits = parts.size() > 1 && std::ranges::all_of(parts, [&](const Part& part) {
                          return are_distinct(part.positions) && part.positions == parts.front().positions;
                        });
      if (!fits) continue;
      if (words.makes_volumes) {
        add_volumes(std::move(parts), words, suffix);
      } else {
        for (Part& part : parts) add({std::move(part.slices)}, suffix + part_name(words, part), {}, {}, {});
      }
      return;
    }
    for (const KeyWords& words : kKeys) {
      auto parts = split_by(slices, positions, words.key);
      if (!words.makes_grids || parts.size() < 2 || parts.size() > slices.size() / 2) continue;
      for (Part& part : parts) split(std::move(part.slices), suffix + part_name(words, part));
      return;
    }
    split_by_order(slices, positions, suffix);
  }

  // Adds slices that have no positions, or a problem, in the order of their instance numbers.
  void add_unplaced(Slices slices) {
    std::ranges::stable_sort(
        slices, {}, [](const Slice& slice) { return std::pair(slice.object->instance_number, slice.frame.index); });
    add({std::move(slices)}, "", {}, {}, {});
  }

 private:
  static std::string part_name(const KeyWords& words, const Part& part) {
    return " (" + std::string(words.name) + " " + (part.value.empty() ? "unknown" : part.value) + ")";
  }

  void add_volumes(std::vector<Part> parts, const KeyWords& words, const std::string& suffix) {
    std::vector<Slices> volumes;
    std::vector<double> times;
    std::string values;
    const double first_time = words.key == Key::acquisition_time ? number_of(parts.front().value) : 0;
    const double step = parts.front().slices.front().object->time_step;
    for (Part& part : parts) {
      const double value = number_of(part.value);
      if (words.to_seconds > 0) times.push_back((value - first_time) * words.to_seconds);
      if (words.key == Key::temporal_position && step > 0) times.push_back((value - 1) * step * 1e-3);
      values += (values.empty() ? "" : ", ") + part.value;
      volumes.push_back(std::move(part.slices));
    }
    std::string note = "the reader separates the volumes by " + std::string(words.name);
    if (times.empty() && volumes.size() <= 20) note += " (" + values + ")";
    add(std::move(volumes), suffix, note, std::move(times), {});
  }

  // Splits slices that share positions, and that no key separates, into volumes by their order.
  void split_by_order(const Slices& slices, const std::vector<std::size_t>& positions, const std::string& suffix) {
    std::vector<Slices> volumes;
    std::vector<std::size_t> counts(positions.back() + 1);
    for (std::size_t i = 0; i < slices.size(); ++i) {
      const std::size_t volume = counts[positions[i]]++;
      if (volume == volumes.size()) volumes.emplace_back();
      volumes[volume].push_back(slices[i]);
    }
    const bool are_volumes = std::ranges::adjacent_find(counts, std::ranges::not_equal_to()) == counts.end();
    if (are_volumes) {
      add(std::move(volumes), suffix, "volumes by the instance numbers of the slices at each position", {}, {});
      return;
    }
    const std::size_t left_out = slices.size() - counts.size();
    add({std::move(volumes.front())}, suffix, {}, {},
        std::to_string(left_out) + (left_out == 1 ? " slice" : " slices") +
            " at the position of another left out: the one with the lowest instance number stays");
  }

  void add(std::vector<Slices> volumes, const std::string& suffix, const std::string& volumes_note,
           std::vector<double> times, const std::string& duplicates_note) {
    Series series;
    const Slice& first = volumes.front().front();
    const Object& object = *first.object;
    const Frame& shape = first.frame;
    const Pixels& pixels = object.pixels;
    for (const std::string& note : {volumes_note, duplicates_note, object.note}) {
      if (!note.empty()) series.notes.push_back(note);
    }
    series.problem = object.problem;
    isoextract_plugin::Grid& grid = series.grid;
    grid.name = series_name(object) + suffix;
    grid.sample_type = sample_type(pixels);
    place(volumes.front(), series);
    set_scale(volumes, series);
    grid.type_name = type_name(grid.sample_type);
    grid.dims[0] = pixels.columns;
    grid.dims[1] = pixels.rows;
    grid.components = pixels.samples_per_pixel;
    if (grid.components == 3) {
      const bool is_ycbcr = pixels.photometric == "YBR_FULL" || pixels.photometric == "YBR_FULL_422";
      grid.component_names = is_ycbcr ? "y cb cr" : "red green blue";
    }
    grid.volumes = volumes.size();
    grid.volume_times = std::move(times);
    if (!grid.volume_times.empty()) grid.time_unit = "s";
    if (!shape.has_spacing) series.notes.emplace_back("the header has no pixel spacing: the reader assumes 1 mm");
    series.volumes = std::move(volumes);
    series_.push_back(std::move(series));
  }

  void place(const Slices& slices, Series& series) const {
    isoextract_plugin::Grid& grid = series.grid;
    Frame shape = slices.front().frame;
    if (!is_placed(shape)) {
      const bool has_distance = shape.slice_distance > 0 || shape.thickness > 0;
      const double distance = shape.slice_distance > 0 ? shape.slice_distance : has_distance ? shape.thickness : 1;
      shape.row_direction = {1, 0, 0};
      shape.column_direction = {0, 1, 0};
      grid.dims[2] = slices.size();
      grid.index_to_world = index_to_world(shape, {0, 0, 0}, {0, 0, distance});
      grid.has_placement = shape.has_spacing;
      if (shape.has_spacing) grid.length_unit = "mm";
      series.notes.push_back(
          "the headers have no positions: the reader places the slices in the order of their instance numbers, " +
          number_text(distance) + " mm apart" + (has_distance ? "" : " (assumed)"));
      return;
    }
    std::vector<Vector> positions;
    for (const Slice& slice : slices) positions.push_back(slice.frame.position);
    Line line = fit_line(positions, shape, resamples_);
    if (series.problem.empty()) {
      series.problem = line.problem;
      series.is_uneven = line.is_uneven;
    }
    if (!line.note.empty()) series.notes.push_back(line.note);
    series.slice_positions = std::move(line.slice_positions);
    grid.dims[2] = line.count;
    grid.index_to_world = index_to_world(shape, line.origin, line.step);
    grid.world_space = "left-posterior-superior";
    grid.length_unit = "mm";
    const double cosine = dot(line.step, normal_of(shape)) / length(line.step);
    const double degrees = std::acos(std::clamp(cosine, -1.0, 1.0)) * 57.29577951308232;
    if (degrees > 0.5)
      series.notes.push_back("the grid is sheared by " + number_text(degrees) + " degrees (gantry tilt)");
    if (slices.front().object->is_stacked)
      series.notes.push_back("the reader places the frames " + number_text(length(line.step)) +
                             " mm apart (Spacing Between Slices)");
  }

  void set_scale(const std::vector<Slices>& volumes, Series& series) const {
    const Frame& first = volumes.front().front().frame;
    double smallest = first.slope;
    double largest = first.slope;
    bool differs = false;
    for (const Slices& slices : volumes) {
      for (const Slice& slice : slices) {
        differs = differs || slice.frame.slope != first.slope || slice.frame.intercept != first.intercept;
        smallest = std::min(smallest, slice.frame.slope);
        largest = std::max(largest, slice.frame.slope);
      }
    }
    isoextract_plugin::Grid& grid = series.grid;
    series.converts = differs || !series.slice_positions.empty();
    if (series.converts) {
      const bool wide = isoextract_plugin::sample_size(grid.sample_type) >= 4;
      grid.sample_type = wide ? ISOEXTRACT_F64 : ISOEXTRACT_F32;
    } else {
      grid.slope = first.slope;
      grid.intercept = first.intercept;
    }
    if (differs) {
      series.notes.push_back("the reader converts slices with different rescale slopes or intercepts (slopes from " +
                             number_text(smallest) + " to " + number_text(largest) + ") to " +
                             type_name(grid.sample_type));
    }
  }

  bool resamples_;
  std::vector<Series>& series_;
};

// Returns text that is equal for all slices of one grid; their geometry is compared separately.
std::string group_key(const Object& object, const Frame& frame) {
  const Pixels& p = object.pixels;
  std::string key = object.series_uid + '|' + object.frame_of_reference + '|' + frame.stack + '|' + p.photometric +
                    '|' + object.problem;
  for (const std::uint32_t number :
       {p.columns, p.rows, p.samples_per_pixel, p.bits_allocated, static_cast<std::uint32_t>(sample_type(p))})
    key += '|' + std::to_string(number);
  return key;
}

}  // namespace

std::string series_name(const Object& object) {
  std::string name = object.series_number;
  if (!object.description.empty()) name += (name.empty() ? "" : " ") + object.description;
  return name.empty() ? object.modality : name;
}

std::vector<Series> make_series(const std::vector<std::shared_ptr<const Object>>& objects, bool resamples,
                                std::vector<std::string>& notes) {
  std::map<std::string, std::vector<Slices>> groups;
  std::set<std::string> instances;
  std::size_t repeated = 0;
  for (const auto& object : objects) {
    if (object->segmentation != Segmentation::none) continue;
    if (!object->instance_uid.empty() && !instances.insert(object->instance_uid).second) {
      ++repeated;
      continue;
    }
    for (const Frame& frame : object->frames) {
      auto& shapes = groups[group_key(*object, frame)];
      auto same =
          std::ranges::find_if(shapes, [&](const Slices& slices) { return same_shape(slices.front().frame, frame); });
      if (same == shapes.end()) same = shapes.insert(shapes.end(), Slices());
      same->push_back({object, frame});
    }
  }
  if (repeated > 0)
    notes.push_back("the reader skips " + std::to_string(repeated) + (repeated == 1 ? " copy" : " copies") +
                    " of the same image");

  std::vector<Series> series;
  Splitter splitter(resamples, series);
  for (auto& [key, shapes] : groups) {
    for (Slices& slices : shapes) {
      if (slices.front().object->problem.empty() && is_placed(slices.front().frame)) {
        splitter.split(std::move(slices), "");
      } else {
        splitter.add_unplaced(std::move(slices));
      }
    }
  }
  const auto is_volume = [](const Series& one) { return one.grid.dims[2] > 1; };
  if (std::ranges::any_of(series, is_volume)) {
    const std::size_t all = series.size();
    std::erase_if(series, [&](const Series& one) { return !is_volume(one); });
    if (const std::size_t left_out = all - series.size(); left_out > 0)
      notes.push_back("the reader skips " + std::to_string(left_out) + " single " +
                      (left_out == 1 ? "image" : "images") + " beside the volumes");
  }
  std::ranges::stable_sort(
      series, {}, [](const Series& one) { return number_of(one.volumes.front().front().object->series_number); });
  return series;
}

}  // namespace isoextract_dicom
