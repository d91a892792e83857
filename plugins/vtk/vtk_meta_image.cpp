// MetaImage (.mha, .mhd), the format of ITK, with samples in the same file, in another, or in one file for each slice.
// This file reads the header itself, because VTK's reader ignores TransformMatrix.
// Format: https://itk.org/Wiki/MetaIO/Documentation; index axis i points along row i of TransformMatrix, as in ITK's
// itkMetaImageIO.cxx.
#include <algorithm>
#include <bit>
#include <filesystem>
#include <map>

#include <zlib.h>

#include "vtk_volume.hpp"

namespace isoextract_vtk {
namespace {

using Header = std::map<std::string, std::string>;
constexpr std::uint64_t kMostHeader = 1 << 20;

std::string trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t\r") - first + 1));
}

struct ReadHeader {
  Header values;
  std::vector<std::string> names;  // of the data files, from the lines after ElementDataFile = LIST
  std::uint64_t bytes = 0;         // of the header, which samples follow if ElementDataFile = LOCAL
};

ReadHeader read_header(const InputFile& file) {
  const std::string text = file.text_at(0, kMostHeader);
  ReadHeader header;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = text.find('\n', at);
    const std::string line = trimmed(std::string_view(text).substr(at, end - at));
    at = end == std::string::npos ? text.size() : end + 1;
    const bool listed = header.values.contains("ElementDataFile");
    if (listed) {
      if (!line.empty()) header.names.push_back(line);
      continue;
    }
    if (line.empty() || line[0] == '#') continue;
    const std::size_t sign = line.find_first_of("=:");
    if (sign == std::string::npos) {
      throw ReadError("expected lines KEY = VALUE, found '" + line.substr(0, 40) + "'");
    }
    const std::string key = trimmed(line.substr(0, sign));
    header.values[key] = trimmed(line.substr(sign + 1));
    if (key == "ElementDataFile" && !header.values[key].starts_with("LIST")) break;
  }
  if (!header.values.contains("ElementDataFile")) throw ReadError("expected a line ElementDataFile = ..., found none");
  header.bytes = at;
  return header;
}

// Returns the value of the first of `keys` that the header has; "" if it has none.
std::string value_of(const Header& header, const std::vector<std::string>& keys) {
  for (const std::string& key : keys) {
    if (const auto found = header.find(key); found != header.end()) return found->second;
  }
  return {};
}

std::vector<double> numbers_of(const Header& header, const std::vector<std::string>& keys, std::size_t count) {
  const std::vector<std::string> words = words_of(value_of(header, keys));
  if (words.empty()) return {};
  std::vector<double> numbers;
  for (const std::string& word : words) {
    const auto number = parse_number(word);
    if (number && std::isfinite(*number)) numbers.push_back(*number);
  }
  if (numbers.size() < count || numbers.size() != words.size()) {
    throw ReadError("expected " + std::to_string(count) + " numbers in " + keys[0] + ", found '" +
                    value_of(header, keys).substr(0, 80) + "'");
  }
  return numbers;
}

bool is_true(const std::string& value) {
  return !value.empty() && (value[0] == 'T' || value[0] == 't' || value[0] == '1');
}

StoredType type_of(std::string name) {
  using Wide = StoredType::Wide;
  static const std::map<std::string, StoredType> types{{"MET_UCHAR", {ISOEXTRACT_U8}},
                                                       {"MET_CHAR", {ISOEXTRACT_I8}},
                                                       {"MET_USHORT", {ISOEXTRACT_U16}},
                                                       {"MET_SHORT", {ISOEXTRACT_I16}},
                                                       {"MET_UINT", {ISOEXTRACT_U32}},
                                                       {"MET_INT", {ISOEXTRACT_I32}},
                                                       {"MET_ULONG", {ISOEXTRACT_U32}},
                                                       {"MET_LONG", {ISOEXTRACT_I32}},
                                                       {"MET_FLOAT", {ISOEXTRACT_F32}},
                                                       {"MET_DOUBLE", {ISOEXTRACT_F64}},
                                                       {"MET_ULONG_LONG", {ISOEXTRACT_F64, Wide::u64}},
                                                       {"MET_LONG_LONG", {ISOEXTRACT_F64, Wide::i64}}};
  if (name.ends_with("_ARRAY")) name.resize(name.size() - 6);
  const auto found = types.find(name);
  if (found == types.end())
    throw ReadError("expected an ElementType such as MET_SHORT, found '" + name.substr(0, 40) + "'");
  return found->second;
}

// Reads a zlib or gzip stream at uncompressed byte offsets. Restarts the stream if an offset is before its position.
class InflatedFile {
 public:
  InflatedFile(const InputFile& file, std::uint64_t offset) : file_(file), start_(offset) { restart(); }
  InflatedFile(const InflatedFile&) = delete;
  InflatedFile& operator=(const InflatedFile&) = delete;
  ~InflatedFile() { inflateEnd(&stream_); }

  void read_at(std::uint64_t offset, char* to, std::uint64_t bytes) {
    if (offset < position_) {
      inflateEnd(&stream_);
      restart();
    }
    std::vector<char> skipped(std::size_t{1} << 16);
    while (position_ < offset) next(skipped.data(), std::min<std::uint64_t>(skipped.size(), offset - position_));
    while (bytes > 0) {
      const std::uint64_t part = std::min<std::uint64_t>(bytes, 1 << 30);
      next(to, part);
      to += part;
      bytes -= part;
    }
  }

 private:
  void restart() {
    stream_ = {};
    if (inflateInit2(&stream_, 15 + 32) != Z_OK) throw std::bad_alloc();
    at_ = start_;
    position_ = 0;
  }

  void next(char* to, std::uint64_t bytes) {
    stream_.next_out = reinterpret_cast<Bytef*>(to);
    stream_.avail_out = static_cast<uInt>(bytes);
    while (stream_.avail_out > 0) {
      if (stream_.avail_in == 0) {
        input_ = file_.text_at(at_, 1 << 18);
        at_ += input_.size();
        stream_.next_in = reinterpret_cast<Bytef*>(input_.data());
        stream_.avail_in = static_cast<uInt>(input_.size());
      }
      const int status = inflate(&stream_, Z_NO_FLUSH);
      if (status == Z_OK || (status == Z_STREAM_END && stream_.avail_out == 0)) continue;
      throw ReadError("expected more compressed samples, found " +
                      std::string(stream_.msg != nullptr ? stream_.msg : "the end of the file") + " after " +
                      std::to_string(position_ + bytes - stream_.avail_out) + " bytes of samples");
    }
    position_ += bytes;
  }

  const InputFile& file_;
  std::uint64_t start_ = 0;
  std::uint64_t at_ = 0;        // the next compressed byte
  std::uint64_t position_ = 0;  // uncompressed offset of the next byte
  std::string input_;
  z_stream stream_{};
};

class MetaImage final : public VolumeFile {
 public:
  MetaImage(const Request& request) : path_(request.path) {
    const InputFile header_file(path_);
    const ReadHeader header = read_header(header_file);
    const Header& values = header.values;
    if (const std::string type = value_of(values, {"ObjectType"}); !type.empty() && type != "Image") {
      throw ReadError("expected ObjectType = Image, found " + type.substr(0, 40));
    }
    if (const std::string binary = value_of(values, {"BinaryData"}); !binary.empty() && !is_true(binary)) {
      throw ReadError("expected BinaryData = True, found samples as text");
    }
    format = "MetaImage";
    Grid grid;
    set_size(values, grid);
    place(values, grid);
    set_files(header, grid);
    grids.push_back(std::move(grid));
  }

  ReadFacts read(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) override {
    const Grid& grid = grids[0];
    const std::uint64_t slice = grid.dims[0] * grid.dims[1] * grid.components;  // numbers
    const std::uint64_t bytes = type_.bytes();
    ReadFacts facts;
    // The slices of all volumes follow each other; all files have the same number of slices.
    const std::uint64_t slices = grid.dims[2] * grid.volumes;
    const std::uint64_t slices_per_file = slices / data_.size();
    std::unique_ptr<InputFile> file;
    std::unique_ptr<InflatedFile> inflated;
    std::uint64_t opened = 0;
    const auto read_numbers = [&](std::uint64_t first, std::uint64_t count, void* to) {
      const std::uint64_t all = (selection.volume * grid.dims[2] * slice) + first;
      const std::uint64_t index = all / (slice * slices_per_file);
      if (file == nullptr || index != opened) {
        inflated.reset();
        file = std::make_unique<InputFile>(data_[index]);
        opened = index;
        ++facts.parts_read;
        if (compressed_) inflated = std::make_unique<InflatedFile>(*file, offset_);
      }
      const std::uint64_t at = (all - index * slice * slices_per_file) * bytes;
      if (inflated) {
        inflated->read_at(at, static_cast<char*>(to), count * bytes);
      } else {
        const std::uint64_t held = slice * slices_per_file * bytes;
        if (from_end_ && file->size() < held) check_fits(*file, 0, {slice, slices_per_file}, bytes);
        file->read_at((from_end_ ? file->size() - held : offset_) + at, to, count * bytes);
      }
    };
    fill_from_stored(grid, {{}, grid.dims, type_, swap_}, read_numbers, selection, host);
    facts.parts = data_.size();
    return facts;
  }

 private:
  void set_size(const Header& values, Grid& grid) {
    const auto dimensions = numbers_of(values, {"NDims"}, 1);
    if (dimensions.empty() || (dimensions[0] != 2 && dimensions[0] != 3 && dimensions[0] != 4)) {
      throw ReadError("expected NDims = 2, 3 or 4, found '" + value_of(values, {"NDims"}).substr(0, 40) + "'");
    }
    axes_ = static_cast<std::size_t>(dimensions[0]);
    const auto sizes = numbers_of(values, {"DimSize"}, axes_);
    if (sizes.empty()) throw ReadError("expected a line DimSize = ..., found none");
    grid.dims = {1, 1, 1};
    for (std::size_t axis = 0; axis < axes_; ++axis) {
      if (!(sizes[axis] >= 1 && sizes[axis] <= 2147483647.0 && sizes[axis] == std::floor(sizes[axis]))) {
        throw ReadError("expected positive whole numbers in DimSize, found " +
                        value_of(values, {"DimSize"}).substr(0, 80));
      }
      (axis < 3 ? grid.dims[axis] : grid.volumes) = static_cast<std::uint64_t>(sizes[axis]);
    }
    const auto channels = numbers_of(values, {"ElementNumberOfChannels"}, 1);
    if (!channels.empty() && (channels[0] < 1 || channels[0] > 65536 || channels[0] != std::floor(channels[0]))) {
      throw ReadError("expected a positive ElementNumberOfChannels, found " + printed(channels[0]));
    }
    if (!channels.empty()) grid.components = static_cast<std::uint64_t>(channels[0]);
    grid.type_name = value_of(values, {"ElementType"});
    type_ = type_of(grid.type_name);
    grid.sample_type = type_.sample_type;
    if (type_.wide != StoredType::Wide::none) note = kWideNote;
    const bool big = is_true(value_of(values, {"ElementByteOrderMSB", "BinaryDataByteOrderMSB"}));
    swap_ = big != (std::endian::native == std::endian::big);
    if (const auto slope = numbers_of(values, {"ElementToIntensityFunctionSlope"}, 1); !slope.empty()) {
      grid.slope = slope[0];
    }
    if (const auto offset = numbers_of(values, {"ElementToIntensityFunctionOffset"}, 1); !offset.empty()) {
      grid.intercept = offset[0];
    }
  }

  void place(const Header& values, Grid& grid) {
    auto spacing = numbers_of(values, {"ElementSpacing", "ElementSize"}, axes_);
    grid.has_placement = !spacing.empty();
    spacing.resize(std::max<std::size_t>(spacing.size(), axes_), 1);
    const auto matrix = numbers_of(values, {"TransformMatrix", "Rotation", "Orientation"}, axes_ * axes_);
    const auto offset = numbers_of(values, {"Offset", "Position", "Origin"}, axes_);
    const std::size_t space_axes = std::min<std::size_t>(axes_, 3);
    for (std::size_t axis = 0; axis < space_axes; ++axis) {
      for (std::size_t world = 0; world < space_axes; ++world) {
        const double direction = matrix.empty() ? (world == axis ? 1.0 : 0.0) : matrix[axis * axes_ + world];
        grid.index_to_world[4 * world + axis] = spacing[axis] * direction;
      }
      if (!offset.empty()) grid.index_to_world[4 * axis + 3] = offset[axis];
    }
    if (axes_ == 4) {
      for (std::uint64_t i = 0; i < std::min<std::uint64_t>(grid.volumes, 1 << 20); ++i) {
        grid.volume_times.push_back((offset.empty() ? 0 : offset[3]) + static_cast<double>(i) * spacing[3]);
      }
    }
    grid.length_unit = value_of(values, {"DistanceUnits"});
    if (grid.length_unit == "?") grid.length_unit.clear();
    // ITK writes both keys, and uses DICOM's space (left, posterior, superior).
    if (!matrix.empty() && values.contains("AnatomicalOrientation")) {
      grid.world_space = "left-posterior-superior";
      if (grid.length_unit.empty()) grid.length_unit = "mm";
      note +=
          std::string(note.empty() ? "" : "; ") + "the reader assumes left-posterior-superior space in mm, as ITK does";
    }
  }

  void set_files(const ReadHeader& header, const Grid& grid) {
    const Header& values = header.values;
    const std::string name = value_of(values, {"ElementDataFile"});
    compressed_ = is_true(value_of(values, {"CompressedData"}));
    const auto skipped = numbers_of(values, {"HeaderSize"}, 1);
    from_end_ = !skipped.empty() && skipped[0] == -1;
    if (!skipped.empty() && skipped[0] > 0) offset_ = static_cast<std::uint64_t>(std::min(skipped[0], 1e15));
    std::vector<std::string> names = header.names;
    if (name == "LOCAL" || name == "Local" || name == "local") {
      data_ = {path_};
      offset_ = header.bytes;
      from_end_ = false;
    } else if (name.starts_with("LIST")) {
      if (words_of(name).size() > 1 && words_of(name)[1] != "2D") {
        throw ReadError("expected a list with a file for each slice, found ElementDataFile = " + name.substr(0, 40));
      }
      set_slices(names, grid);
    } else if (name.find('%') != std::string::npos) {
      set_slices(numbered_names(words_of(name)), grid);
    } else {
      data_ = {path_beside(path_, name)};
      files = data_;
    }
    if (compressed_) {
      // zlib's largest ratio is 1032.
      if (data_.size() == 1) check_ratio(InputFile(data_[0]).size(), grid);
      return;
    }
    const std::uint64_t slices = grid.dims[2] * grid.volumes / data_.size();
    check_fits(InputFile(data_[0]), from_end_ ? 0 : offset_, {grid.dims[0], grid.dims[1], slices, grid.components},
               type_.bytes());
  }

  void check_ratio(std::uint64_t bytes, const Grid& grid) const {
    const auto numbers =
        product({grid.dims[0], grid.dims[1], grid.dims[2], grid.volumes, grid.components}, bytes * 1040);
    if (!numbers)
      throw ReadError("expected samples that " + std::to_string(bytes) +
                      " compressed bytes can hold, found more in DimSize");
  }

  void set_slices(const std::vector<std::string>& names, const Grid& grid) {
    const auto slices = product({grid.dims[2], grid.volumes}, 1 << 24);
    if (!slices || names.size() != *slices) {
      throw ReadError("expected a file for each of the " + std::to_string(grid.dims[2]) + " x " +
                      std::to_string(grid.volumes) + " slices, found " + std::to_string(names.size()));
    }
    for (const std::string& slice : names) data_.push_back(path_beside(path_, slice));
    files = data_;
  }

  // ElementDataFile = slice%03d.raw FIRST LAST STEP
  static std::vector<std::string> numbered_names(const std::vector<std::string>& words) {
    const std::int64_t first = words.size() > 2 ? parse_integer(words[1]).value_or(-1) : -1;
    const std::int64_t last = words.size() > 2 ? parse_integer(words[2]).value_or(-1) : -1;
    const std::int64_t step = words.size() > 3 ? parse_integer(words[3]).value_or(0) : 1;
    const std::size_t percent = words.empty() ? std::string::npos : words[0].find('%');
    const std::size_t letter =
        percent == std::string::npos ? percent : words[0].find_first_not_of("0123456789", percent + 1);
    if (first < 0 || step < 1 || last < first || last - first > (1 << 24) || letter == std::string::npos ||
        (words[0][letter] != 'd' && words[0][letter] != 'i')) {
      throw ReadError("expected ElementDataFile = NAME%03d FIRST LAST STEP, found '" +
                      (words.empty() ? std::string() : words[0].substr(0, 80)) + "'");
    }
    const auto width =
        static_cast<std::size_t>(parse_integer(words[0].substr(percent + 1, letter - percent - 1)).value_or(0));
    if (width > 20) throw ReadError("expected numbers of at most 20 digits in ElementDataFile");
    std::vector<std::string> names;
    for (std::int64_t i = first; i <= last; i += step) {
      std::string number = std::to_string(i);
      if (number.size() < width) number.insert(0, width - number.size(), '0');
      names.push_back(words[0].substr(0, percent) + number + words[0].substr(letter + 1));
    }
    return names;
  }

  std::string path_;
  std::size_t axes_ = 3;
  StoredType type_;
  bool swap_ = false;
  bool compressed_ = false;
  bool from_end_ = false;  // HeaderSize = -1: the samples end with the file
  std::uint64_t offset_ = 0;
  std::vector<std::string> data_;  // paths of the files with samples
};

}  // namespace

Opened open_meta_image(const Request& request, const isoextract_plugin_host& /*host*/) {
  return std::make_unique<MetaImage>(request);
}

}  // namespace isoextract_vtk
