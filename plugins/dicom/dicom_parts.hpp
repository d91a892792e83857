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
  std::shared_ptr<const std::string> inflated;  // the inflated bytes of a deflated file, in which `offset` counts
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
  std::uint32_t index = 0;  // in the file, from 0
  bool has_position = false;
  bool has_orientation = false;
  bool has_spacing = false;
  Vector position{};                             // of the center of its first pixel, in mm
  Vector row_direction{}, column_direction{};    // unit vectors along a row (to the next column), along a column
  double column_distance = 1, row_distance = 1;  // between neighboring columns, rows, in mm
  double thickness = 0, slice_distance = 0;      // in mm; 0 if not stated
  double slope = 1, intercept = 0;
  std::string stack;
  std::array<std::string, static_cast<std::size_t>(Key::count)> keys;
  std::uint32_t segment = 0;  // segmentations: number of the segment; 0 if not stated

  [[nodiscard]] const std::string& key(Key which) const { return keys[static_cast<std::size_t>(which)]; }
};

struct Segment {
  std::uint32_t number = 0;
  isoextract_plugin::Label label;
};

enum class Segmentation { none, binary, fractional, label_map };

// Content of a file's header. Its texts for the user have nothing that Patient::is_in() finds.
struct Object {
  Pixels pixels;
  std::string class_uid, instance_uid, series_uid, frame_of_reference;
  std::string series_number, description, modality, device;
  double instance_number = 0;
  double time_step = 0;     // ms between temporal positions; 0 if not stated
  std::string problem;      // why the pixels cannot be decoded, such as an unknown form; empty if they can
  std::string note;         // for the user, about the pixel values
  bool is_stacked = false;  // the file states one position; Spacing Between Slices places the other frames
  std::vector<Frame> frames;
  Segmentation segmentation = Segmentation::none;
  bool segments_are_disjoint = false;  // as the file says
  double full_fraction = 1;            // fractional: the stored value of the fraction 1
  std::vector<Segment> segments;
};

// Reads the header of a file up to the pixels. Returns null for an object without pixels, such as a report. Throws
// ReadError for files that are cut or damaged. Reserves host memory for the content of a deflated file.
std::shared_ptr<const Object> read_object(const std::string& path, const isoextract_plugin_host& host);

// Returns the type of the decoded samples; ISOEXTRACT_NOT_SCALAR for an unsupported number of bits.
std::int32_t sample_type(const Pixels& pixels);
// Returns why pixels of this form cannot be decoded; empty if they can.
std::string form_problem(const Pixels& pixels);
// Throws ReadError if the pixel data is too short, or its compressed pieces do not match the number of frames.
void check_size(const Pixels& pixels);

// Decodes frames of one file.
class PixelReader {
 public:
  explicit PixelReader(const Pixels& pixels);
  ~PixelReader();
  PixelReader(const PixelReader&) = delete;
  PixelReader& operator=(const PixelReader&) = delete;

  // Returns the samples of a frame in native byte order, without unused bits; 1-bit pixels as bytes 0 and 1. Valid
  // until the next call. Throws ReadError if the frame cannot be decoded.
  const std::vector<std::byte>& frame(std::uint32_t index);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

// The files of an input, and a note on the files that were passed over or are missing.
struct FoundFiles {
  std::vector<std::string> paths;
  bool is_single_input = false;  // if so, `paths` are all DICOM files of its folder, of any series
  std::string note;
};
// Throws ReadError if a folder or a DICOMDIR has no DICOM files.
FoundFiles find_files(const isoextract_plugin::Request& request, const isoextract_plugin_host& host);
bool has_dicom_signature(const std::string& path);

// One slice of a volume.
struct Slice {
  std::shared_ptr<const Object> object;
  Frame frame;
};

// One grid of one or more volumes. Slices have one size and orientation; they are in the order of their positions, or
// of their instance numbers if they have no positions.
struct Series {
  isoextract_plugin::Grid grid;
  std::vector<std::vector<Slice>> volumes;
  std::vector<double>
      slice_positions;     // resampled: for each z index of the grid, the slice index with a fraction; else empty
  bool converts = false;   // samples become float or double by each slice's slope and intercept (see set_scale)
  std::string problem;     // why the samples cannot be read; empty if they can
  bool is_uneven = false;  // the problem is that slice distances differ
  std::vector<std::string> notes;
};

// Groups images into series, sorted by series number; skips segmentations, repeated images and, beside volumes, single
// images. `resamples`: resamples unevenly spaced slices. Appends to `notes` the numbers of images passed over.
std::vector<Series> make_series(const std::vector<std::shared_ptr<const Object>>& objects, bool resamples,
                                std::vector<std::string>& notes);

// Positions of the grid's samples along z, in mm: origin + k * step, for k below `count`.
struct Line {
  Vector origin{}, step{};
  std::size_t count = 0;
  std::vector<double> slice_positions;  // as Series::slice_positions
  std::string problem;
  bool is_uneven = false;  // the problem is that distances differ
  std::string note;
};
// Fits a line to sorted positions of one or more slices. `shape` has their directions and distances. Sets Line::problem
// if slices are off the line or, unless `resamples`, unevenly spaced.
Line fit_line(const std::vector<Vector>& positions, const Frame& shape, bool resamples);

Vector cross(const Vector& a, const Vector& b);
double dot(const Vector& a, const Vector& b);
double length(const Vector& a);
inline Vector minus(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vector plus(const Vector& a, const Vector& b, double factor) {
  return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}
inline Vector normal_of(const Frame& frame) { return cross(frame.row_direction, frame.column_direction); }
// Returns whether two frames have the same directions and pixel distances up to rounding, and the same has_... members.
bool same_shape(const Frame& a, const Frame& b);
// Returns the index-to-world transform of samples: x along the rows, y along the columns, z along the step.
std::array<double, 12> index_to_world(const Frame& frame, const Vector& origin, const Vector& step);
// Returns a number with up to 6 significant digits: "2.5".
std::string number_text(double value);
// Returns "SERIESNUMBER DESCRIPTION", or the modality if both are empty.
std::string series_name(const Object& object);

// The grids of one segmentation object: first the label maps, one for each set of segments without overlaps. In a
// fractional object, one grid of fractions for each segment follows.
class SegmentationGrids {
 public:
  // Reads all frames to find overlaps; not for label maps, a single segment, or if the file excludes overlaps. Throws
  // ReadError if the object cannot be read as grids.
  SegmentationGrids(std::shared_ptr<const Object> object, const isoextract_plugin_host& host);

  std::vector<isoextract_plugin::Grid> grids;
  std::string note;

  isoextract_plugin::ReadFacts read(std::size_t grid, const isoextract_volume_selection& selection,
                                    const isoextract_plugin_host& host) const;

 private:
  struct Placed {
    std::uint32_t frame;
    std::uint32_t segment;  // index in object_->segments; 0 for label maps
    std::uint64_t slice;    // z index in the grid
  };
  void place_frames();
  std::vector<std::vector<std::uint32_t>> layers(const isoextract_plugin_host& host) const;
  void add_grids(const std::vector<std::vector<std::uint32_t>>& layers);

  std::shared_ptr<const Object> object_;
  std::vector<Placed> frames_;
  Vector origin_{}, step_{};
  std::uint64_t slices_ = 0;
  std::vector<std::vector<std::uint32_t>> grid_segments_;  // for each grid: indices in object_->segments
  std::size_t label_map_count_ = 0;                        // label maps are first in `grids`
};

// Converts RecommendedDisplayCIELabValue (three 16-bit numbers) to sRGB, each from 0 to 1.
std::array<double, 3> srgb_of_dicom_lab(const std::array<double, 3>& encoded);

}  // namespace isoextract_dicom
