// Shared by the files of this plug-in. A DICOM object is a file; a frame is one image of an object; a slice is a frame
// in a volume. Tags and attribute names are those of DICOM PS3.6.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <volume_reader.hpp>

namespace isoextract_dicom {

using isoextract_plugin::ReadError;
using Vector = std::array<double, 3>;

// Position and form of the pixels in a file.
struct Pixels {
  std::string path;
  std::string transfer_syntax;  // its UID
  std::uint64_t offset = 0;     // of the value of the pixel data
  std::uint64_t bytes = 0;      // of that value; 0 if it is encapsulated
  bool encapsulated = false;
  bool big_endian = false;
  bool is_float = false;
  std::shared_ptr<const std::string> inflated;  // the bytes of a deflated file; offsets refer to them
  std::uint32_t columns = 0, rows = 0, frames = 1;
  std::uint32_t samples_per_pixel = 1;
  bool planar = false;  // color planes follow one another
  std::uint32_t bits_allocated = 0, bits_stored = 0, high_bit = 0;
  bool is_signed = false;
  std::string photometric;

  [[nodiscard]] std::uint64_t samples() const { return std::uint64_t{columns} * rows * samples_per_pixel; }
};

// Attributes that tell apart images at the same position, in the order in which they are tried.
enum class Key {
  image_type,
  temporal_position,
  trigger_time,    // ms
  reference_time,  // ms
  echo_number,
  echo_time,  // ms
  b_value,
  acquisition_number,
  acquisition_time,  // s
  count
};

// One image of an object.
struct Frame {
  std::uint32_t index = 0;  // in its file
  bool has_position = false;
  bool has_orientation = false;
  bool has_spacing = false;
  Vector position{};                           // of the center of its first pixel, in mm
  Vector row_direction{}, column_direction{};  // along a row (to the next column), along a column
  double column_distance = 1, row_distance = 1;
  double thickness = 0, slice_distance = 0;  // 0 if not stated
  double slope = 1, intercept = 0;
  std::string stack;
  std::array<std::string, static_cast<std::size_t>(Key::count)> keys;
  std::uint32_t segment = 0;  // of a segmentation

  [[nodiscard]] const std::string& key(Key which) const { return keys[static_cast<std::size_t>(which)]; }
};

struct Segment {
  std::uint32_t number = 0;
  isoextract_plugin::Label label;
};

enum class Segmentation { none, binary, fractional, label_map };

// Contents of the header of a file. Nothing in it identifies the patient.
struct Object {
  Pixels pixels;
  std::string class_uid, instance_uid, series_uid, frame_of_reference;
  std::string series_number, description, modality, device;
  double instance_number = 0;
  double time_step = 0;     // ms between temporal positions; 0 if not stated
  std::string problem;      // why its pixels cannot be read, such as an unknown form; empty if they can
  std::string note;         // about its values
  bool is_stacked = false;  // its frames were placed by the distance between frames, not by a position of each
  std::vector<Frame> frames;
  Segmentation segmentation = Segmentation::none;
  bool segments_exclude = false;  // the file says that no two segments overlap
  double full_fraction = 1;       // the stored value that means 1
  std::vector<Segment> segments;
};

// Reads the header of a file up to the pixels. Returns null for an object without pixels, such as a report. Throws
// ReadError for files that are cut or damaged. Reserves memory in the host for pixels of deflated files.
std::shared_ptr<const Object> read_object(const std::string& path, const isoextract_plugin_host& host);

// Returns the type of the decoded samples.
std::int32_t sample_type(const Pixels& pixels);
// Returns why pixels of this form cannot be decoded; empty if they can.
std::string form_problem(const Pixels& pixels);
// Throws if the file has too few bytes for its frames.
void check_size(const Pixels& pixels);

// Decodes frames of one file.
class PixelReader {
 public:
  explicit PixelReader(const Pixels& pixels);
  ~PixelReader();
  PixelReader(const PixelReader&) = delete;
  PixelReader& operator=(const PixelReader&) = delete;

  // Returns the samples of a frame in native byte order, without unused bits; 1-bit pixels as bytes 0 and 1. Valid
  // until the next call.
  const std::vector<std::byte>& frame(std::uint32_t index);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

// The files of an input, and what was left out to get at them.
struct FoundFiles {
  std::vector<std::string> paths;
  bool siblings = false;  // the path is the file of a series, whose other files are beside it
  std::string note;
};
FoundFiles find_files(const isoextract_plugin::Request& request, const isoextract_plugin_host& host);
bool has_dicom_signature(const std::string& path);

// One slice of a volume.
struct Slice {
  std::shared_ptr<const Object> object;
  Frame frame;
};

// Slices with one size and orientation, in the order of their positions: one grid, of one or more volumes.
struct Series {
  isoextract_plugin::Grid grid;
  std::vector<std::vector<Slice>> volumes;
  std::vector<double> places;  // resampled: of each sample along z, its place among the slices; empty otherwise
  bool converts = false;       // to float, with the slope and intercept of each slice
  std::string problem;         // why its samples cannot be read; empty if they can
  bool is_uneven = false;      // the problem is that slice distances differ
  std::vector<std::string> notes;
};

// Splits images into series, sorted by series number. `resamples`: resamples uneven slice distances.
std::vector<Series> make_series(const std::vector<std::shared_ptr<const Object>>& objects, bool resamples,
                                std::vector<std::string>& notes);

// Positions along a straight line, evenly spaced but for `places`.
struct Line {
  Vector origin{}, step{};
  std::size_t count = 0;
  std::vector<double> places;  // as Series::places
  std::string problem;
  bool is_uneven = false;  // the problem is that distances differ
  std::string note;
};
// Fits a line to sorted positions of slices. Throws nothing: uneven distances are its problem unless resamples.
Line fit_line(const std::vector<Vector>& positions, const Frame& shape, bool resamples);

Vector cross(const Vector& a, const Vector& b);
double dot(const Vector& a, const Vector& b);
double length(const Vector& a);
inline Vector minus(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vector plus(const Vector& a, const Vector& b, double factor) {
  return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}
inline Vector normal_of(const Frame& frame) { return cross(frame.row_direction, frame.column_direction); }
// Returns whether two frames have the same directions and pixel distances.
bool same_shape(const Frame& a, const Frame& b);
// Returns the index-to-world transform of samples: x along the rows, y along the columns, z along the step.
std::array<double, 12> index_to_world(const Frame& frame, const Vector& origin, const Vector& step);
// Returns a number with up to 6 digits: "2.5".
std::string number_text(double value);
// "SERIESNUMBER DESCRIPTION".
std::string series_name(const Object& object);

// The grids of one segmentation object: label maps, one for each set of segments that do not overlap, and for
// fractional ones the fractions of each segment.
class SegmentationGrids {
 public:
  // Reads all frames if overlaps have to be found.
  SegmentationGrids(std::shared_ptr<const Object> object, const isoextract_plugin_host& host);

  std::vector<isoextract_plugin::Grid> grids;
  std::string note;

  isoextract_plugin::ReadFacts read(std::size_t grid, const isoextract_volume_selection& selection,
                                    const isoextract_plugin_host& host) const;

 private:
  struct Placed {
    std::uint32_t frame;
    std::uint32_t segment;  // its place in object_->segments
    std::uint64_t slice;
  };
  void place_frames();
  std::vector<std::vector<std::uint32_t>> layers(const isoextract_plugin_host& host) const;
  void add_grids(const std::vector<std::vector<std::uint32_t>>& layers);

  std::shared_ptr<const Object> object_;
  std::vector<Placed> frames_;
  Vector origin_{}, step_{};
  std::uint64_t slices_ = 0;
  std::vector<std::vector<std::uint32_t>> grid_segments_;  // of each grid
  std::size_t label_maps_ = 0;                             // the first grids
};

// Converts RecommendedDisplayCIELabValue (three 16-bit numbers) to sRGB.
std::array<double, 3> srgb_of_dicom_lab(const std::array<double, 3>& encoded);

}  // namespace isoextract_dicom
