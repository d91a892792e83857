// Digital elevation models of the USGS (.dem): one layer of heights. Format: U.S. Geological Survey, Standards for
// Digital Elevation Models, Part 2: Specifications, 1998. Records have fixed columns. VTK's reader (9.1) crashes if an
// optional field is missing, so this file reads the profiles itself.
#include <algorithm>
#include <cmath>
#include <limits>

#include "vtk_volume.hpp"

namespace isoextract_vtk {
namespace {

constexpr std::uint64_t kRecord = 1024;

class Dem final : public VolumeFile {
 public:
  Dem(const Request& request, const isoextract_plugin_host& host) : file_(request.path) {
    format = "USGS DEM";
    const std::string head = file_.text_at(0, kRecord);
    if (head.size() < kRecord) throw ReadError("expected a header of 1024 bytes, found " + std::to_string(head.size()));
    // Writers may end each record with a line end.
    const std::string ends = file_.text_at(kRecord, 2);
    stride_ = kRecord + (ends == "\r\n" ? 2 : !ends.empty() && ends[0] == '\n' ? 1 : 0);
    const auto profiles = static_cast<std::uint64_t>(number(head, 858, 6, "number of profiles", 1, 1e6));
    const int unit = static_cast<int>(number(head, 528, 6, "unit", 0, 4));
    const std::array<double, 2> step{number(head, 816, 12, "resolution along x", 1e-9, 1e9),
                                     number(head, 828, 12, "resolution along y", 1e-9, 1e9)};
    height_step_ = number(head, 840, 12, "resolution of heights", 1e-9, 1e9);
    if (profiles > file_.size() / kRecord) {
      throw ReadError("expected a record for each of " + std::to_string(profiles) + " profiles, found " +
                      std::to_string(file_.size()) + " bytes");
    }
    read_profiles(profiles, host);
    Grid grid;
    double first = std::numeric_limits<double>::infinity();
    double last = -first;
    for (const Profile& profile : profiles_) {
      first = std::min(first, profile.y);
      last = std::max(last, profile.y + step[1] * static_cast<double>(profile.heights.size() - 1));
    }
    const double rows = std::round((last - first) / step[1]) + 1;
    if (!(rows >= 1 && rows <= 1e6))
      throw ReadError("expected profiles that together span at most 1,000,000 rows, found more");
    grid.dims = {profiles, static_cast<std::uint64_t>(rows), 1};
    grid.index_to_world = {step[0], 0, 0, profiles_[0].x, 0, step[1], 0, first, 0, 0, 1, 0};
    for (Profile& profile : profiles_)
      profile.row = static_cast<std::uint64_t>(std::round((profile.y - first) / step[1]));
    grid.sample_type = ISOEXTRACT_F32;
    grid.type_name = "heights";
    grid.length_unit = unit == 1 ? "ft" : unit == 2 ? "m" : "";
    grid.name = "elevation";
    note = "the values are heights in " +
           std::string(number(head, 534, 6, "unit of heights", 0, 4) == 1 ? "feet" : "meters");
    if (unit == 3) note += ", the coordinates are arc seconds";
    grids.push_back(std::move(grid));
  }

  ReadFacts read(const isoextract_volume_selection& selection, const isoextract_plugin_host& /*host*/) override {
    auto* const to = static_cast<float*>(selection.box);
    for (std::uint64_t y = 0; y < selection.count[1]; ++y) {
      for (std::uint64_t x = 0; x < selection.count[0]; ++x) {
        const Profile& profile = profiles_[selection.first[0] + x];
        const std::uint64_t row = selection.first[1] + y;
        const bool there = row >= profile.row && row - profile.row < profile.heights.size();
        to[y * selection.count[0] + x] =
            there ? profile.heights[row - profile.row] : std::numeric_limits<float>::quiet_NaN();
      }
    }
    return {};
  }

 private:
  struct Profile {
    double x = 0;
    double y = 0;  // of the first height
    std::uint64_t row = 0;
    std::vector<float> heights;  // NaN where there are none
  };

  // Returns the number in `width` columns of a record, from `column` (from 0) on.
  static double number(const std::string& record, std::size_t column, std::size_t width, const char* what, double least,
                       double most) {
    const std::vector<std::string> words = words_of(std::string_view(record).substr(column, width));
    const auto value = words.size() == 1 ? parse_number(words[0]) : std::nullopt;
    if (!value || !(*value >= least && *value <= most)) {
      throw ReadError(std::string("expected the ") + what + " in columns " + std::to_string(column + 1) + " to " +
                      std::to_string(column + width) + ", found '" +
                      record.substr(column, std::min<std::size_t>(width, 40)) + "'");
    }
    return *value;
  }

  void read_profiles(std::uint64_t count, const isoextract_plugin_host& host) {
    constexpr std::size_t kInFirst = 146;  // heights in a profile's first record
    constexpr std::size_t kInOthers = 170;
    HostMemory memory(host);
    memory.take(file_.size());
    std::uint64_t record_number = 1;
    for (std::uint64_t i = 0; i < count; ++i) {
      isoextract_plugin::check_cancelled(host);
      std::string record = next_record(record_number);
      const auto heights = static_cast<std::uint64_t>(number(record, 12, 6, "number of heights", 1, 1e6));
      Profile profile;
      profile.x = number(record, 24, 24, "x of a profile", -1e12, 1e12);
      profile.y = number(record, 48, 24, "y of a profile", -1e12, 1e12);
      const double datum = number(record, 72, 24, "datum of a profile", -1e6, 1e6);
      std::size_t column = 144;
      std::size_t left = kInFirst;
      for (std::uint64_t h = 0; h < heights; ++h) {
        if (left == 0) {
          record = next_record(record_number);
          column = 0;
          left = kInOthers;
        }
        const double value = number(record, column, 6, "height", -99999, 999999);
        if (record[column + 5] == ' ') throw ReadError("expected a height that fills six columns, found a shorter one");
        const bool is_void = value <= -32766;
        profile.heights.push_back(is_void ? std::numeric_limits<float>::quiet_NaN()
                                          : static_cast<float>(datum + value * height_step_));
        column += 6;
        --left;
      }
      profiles_.push_back(std::move(profile));
    }
    memory.keep();
  }

  // Blanks at the end of the last record may be missing.
  std::string next_record(std::uint64_t& record_number) const {
    std::string record = file_.text_at(record_number * stride_, kRecord);
    if (record.empty()) throw ReadError("expected more profiles, found the end of the file");
    record.resize(kRecord, ' ');
    ++record_number;
    return record;
  }

  InputFile file_;
  std::uint64_t stride_ = kRecord;
  double height_step_ = 1;
  std::vector<Profile> profiles_;
};

}  // namespace

Opened open_dem(const Request& request, const isoextract_plugin_host& host) {
  return std::make_unique<Dem>(request, host);
}

}  // namespace isoextract_vtk
