#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "segy_survey.hpp"

namespace isoextract_segy {
namespace {

struct TracePlace {
  std::int32_t inline_number = 0;
  std::int32_t crossline = 0;
  std::int32_t offset = 0;
  double x = 0;
  double y = 0;
};

std::int32_t field(const char* header, int which) {
  std::int32_t value = 0;
  if (segy_get_field(header, which, &value) != SEGY_OK) throw ReadError("segyio cannot read a trace header");
  return value;
}

// Bytes 71-72: positive values multiply coordinates, negative ones divide them.
double coordinate_scale(std::int32_t scalar) {
  if (scalar == 0) return 1;
  return scalar > 0 ? scalar : 1.0 / -static_cast<double>(scalar);
}

std::string number_text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.7g", value);
  return text.data();
}

std::string place_text(const TracePlace& place) {
  return "inline " + std::to_string(place.inline_number) + ", crossline " + std::to_string(place.crossline);
}

Lines find_lines(const std::vector<TracePlace>& places, std::int32_t TracePlace::*number, const std::string& what) {
  std::vector<std::int64_t> numbers;
  numbers.reserve(places.size());
  for (const TracePlace& place : places) numbers.push_back(place.*number);
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  if (numbers.size() < 2) {
    throw ReadError("expected a 3-D volume with several " + what + " in its trace headers, found only number " +
                    std::to_string(numbers[0]));
  }
  Lines lines;
  lines.first = numbers.front();
  lines.step = 0;
  for (std::size_t i = 1; i < numbers.size(); ++i) lines.step = std::gcd(lines.step, numbers[i] - numbers[i - 1]);
  lines.count = static_cast<std::uint64_t>((numbers.back() - numbers.front()) / lines.step) + 1;
  return lines;
}

// Least squares fit of a coordinate to (u, v, 1): grid indices y and z relative to the center of the lattice.
class PlaneFit {
 public:
  PlaneFit(double center_u, double center_v, double offset) : u0_(center_u), v0_(center_v), offset_(offset) {}

  void add(double u, double v, double value) {
    u -= u0_;
    v -= v0_;
    value -= offset_;
    const std::array<double, 3> row{u, v, 1};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) normal_[i][j] += row[i] * row[j];
      right_[i] += row[i] * value;
    }
  }

  // Sets the factors of u and v, and the constant. Returns false if there is no fit: traces lie on at least two lines
  // of each direction, but may still lie on one diagonal.
  [[nodiscard]] bool solve(std::array<double, 3>& factors) const {
    auto m = normal_;
    auto r = right_;
    for (std::size_t i = 0; i < 3; ++i) {
      std::size_t pivot = i;
      for (std::size_t row = i + 1; row < 3; ++row) {
        if (std::abs(m[row][i]) > std::abs(m[pivot][i])) pivot = row;
      }
      if (!(std::abs(m[pivot][i]) > 1e-9 * normal_[i][i])) return false;
      std::swap(m[i], m[pivot]);
      std::swap(r[i], r[pivot]);
      for (std::size_t row = i + 1; row < 3; ++row) {
        const double factor = m[row][i] / m[i][i];
        for (std::size_t column = i; column < 3; ++column) m[row][column] -= factor * m[i][column];
        r[row] -= factor * r[i];
      }
    }
    for (std::size_t i = 3; i-- > 0;) {
      for (std::size_t column = i + 1; column < 3; ++column) r[i] -= m[i][column] * factors[column];
      factors[i] = r[i] / m[i][i];
    }
    factors[2] += offset_ - factors[0] * u0_ - factors[1] * v0_;
    return true;
  }

 private:
  double u0_;
  double v0_;
  double offset_;
  std::array<std::array<double, 3>, 3> normal_{};
  std::array<double, 3> right_{};
};

double grid_y(const Survey& survey, const TracePlace& place) {
  const std::int64_t number = survey.inlines_are_slow ? place.crossline : place.inline_number;
  return static_cast<double>((number - survey.fast.first) / survey.fast.step);
}

double grid_z(const Survey& survey, const TracePlace& place) {
  const std::int64_t number = survey.inlines_are_slow ? place.inline_number : place.crossline;
  return static_cast<double>((number - survey.slow.first) / survey.slow.step);
}

// Takes the inline number as world x, and the crossline number as y.
void place_by_lines(Survey& survey) {
  const std::size_t fast_row = survey.inlines_are_slow ? 3 : 0;
  const std::size_t slow_row = 3 - fast_row;
  survey.plane[fast_row] = static_cast<double>(survey.fast.step);
  survey.plane[fast_row + 2] = static_cast<double>(survey.fast.first);
  survey.plane[slow_row + 1] = static_cast<double>(survey.slow.step);
  survey.plane[slow_row + 2] = static_cast<double>(survey.slow.first);
  survey.note += "x is the inline number, y the crossline number";
}

// Returns false if the headers' coordinates span no plane.
bool place_by_coordinates(Survey& survey, const std::vector<TracePlace>& places) {
  const double middle_y = static_cast<double>(survey.fast.count - 1) / 2;
  const double middle_z = static_cast<double>(survey.slow.count - 1) / 2;
  PlaneFit x(middle_y, middle_z, places[0].x);
  PlaneFit y(middle_y, middle_z, places[0].y);
  for (const TracePlace& place : places) {
    x.add(grid_y(survey, place), grid_z(survey, place), place.x);
    y.add(grid_y(survey, place), grid_z(survey, place), place.y);
  }
  std::array<double, 3> fx{};
  std::array<double, 3> fy{};
  if (!x.solve(fx) || !y.solve(fy)) return false;
  const double along_fast = std::hypot(fx[0], fy[0]);
  const double along_slow = std::hypot(fx[1], fy[1]);
  const double area = std::abs(fx[0] * fy[1] - fx[1] * fy[0]);
  if (!(area > 1e-3 * along_fast * along_slow)) return false;
  double residual = 0;
  for (const TracePlace& place : places) {
    const double u = grid_y(survey, place);
    const double v = grid_z(survey, place);
    residual = std::max(residual,
                        std::hypot(fx[0] * u + fx[1] * v + fx[2] - place.x, fy[0] * u + fy[1] * v + fy[2] - place.y));
  }
  survey.plane = {fx[0], fx[1], fx[2], fy[0], fy[1], fy[2]};
  survey.note += "x and y are the coordinates of the traces, fitted within " + number_text(residual) +
                 "; inlines are " + number_text(survey.inlines_are_slow ? along_slow : along_fast) + ", crosslines " +
                 number_text(survey.inlines_are_slow ? along_fast : along_slow) + " apart";
  return true;
}

std::vector<TracePlace> read_places(const SegyFile& file, const isoextract_plugin_host& host, Survey& survey) {
  std::vector<TracePlace> places(static_cast<std::size_t>(file.traces()));
  std::array<char, SEGY_TRACE_HEADER_SIZE> header{};
  bool delays_differ = false;
  for (int i = 0; i < file.traces(); ++i) {
    if (i % 1024 == 0) isoextract_plugin::check_cancelled(host);
    file.read_header(i, header.data());
    TracePlace& place = places[static_cast<std::size_t>(i)];
    place.inline_number = field(header.data(), SEGY_TR_INLINE);
    place.crossline = field(header.data(), SEGY_TR_CROSSLINE);
    place.offset = field(header.data(), SEGY_TR_OFFSET);
    const double scale = coordinate_scale(field(header.data(), SEGY_TR_SOURCE_GROUP_SCALAR));
    place.x = scale * field(header.data(), SEGY_TR_CDP_X);
    place.y = scale * field(header.data(), SEGY_TR_CDP_Y);
    const double delay = field(header.data(), SEGY_TR_DELAY_REC_TIME);
    if (i == 0) survey.delay_ms = delay;
    delays_differ = delays_differ || delay != survey.delay_ms;
  }
  if (delays_differ) {
    throw ReadError("expected traces that begin at the same time, found delays (bytes 109-110) other than the " +
                    number_text(survey.delay_ms) + " ms of the first");
  }
  return places;
}

void fill_table(Survey& survey, const std::vector<TracePlace>& places) {
  survey.trace.assign(survey.fast.count * survey.slow.count, -1);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto y = static_cast<std::uint64_t>(grid_y(survey, places[i]));
    const auto z = static_cast<std::uint64_t>(grid_z(survey, places[i]));
    std::int32_t& entry = survey.trace[z * survey.fast.count + y];
    if (entry >= 0) {
      const TracePlace& other = places[static_cast<std::size_t>(entry)];
      const std::string where = "expected one trace per place, found several at " + place_text(other);
      if (other.offset == places[i].offset) throw ReadError(where);
      throw ReadError(where + ", of offsets " + std::to_string(other.offset) + " and " +
                      std::to_string(places[i].offset) + ": the file has traces before stacking");
    }
    entry = static_cast<std::int32_t>(i);
  }
  survey.missing = survey.trace.size() - places.size();
}

}  // namespace

Survey read_survey(const SegyFile& file, const isoextract_plugin_host& host) {
  Survey survey;
  HostMemory places_memory(host);
  places_memory.take(static_cast<std::uint64_t>(file.traces()) * (sizeof(TracePlace) + sizeof(std::int64_t)));
  const std::vector<TracePlace> places = read_places(file, host, survey);
  const Lines inlines = find_lines(places, &TracePlace::inline_number, "inlines (bytes 189-192)");
  const Lines crosslines = find_lines(places, &TracePlace::crossline, "crosslines (bytes 193-196)");
  // Consecutive traces differ in the number (inline or crossline) that varies faster.
  std::uint64_t inline_changes = 0;
  std::uint64_t crossline_changes = 0;
  for (std::size_t i = 1; i < places.size(); ++i) {
    inline_changes += places[i].inline_number != places[i - 1].inline_number ? 1 : 0;
    crossline_changes += places[i].crossline != places[i - 1].crossline ? 1 : 0;
  }
  survey.inlines_are_slow = inline_changes <= crossline_changes;
  survey.fast = survey.inlines_are_slow ? crosslines : inlines;
  survey.slow = survey.inlines_are_slow ? inlines : crosslines;

  // A survey of any outline fills at least a tenth of its bounding box; wrong line numbers do not.
  const double cells = static_cast<double>(inlines.count) * static_cast<double>(crosslines.count);
  if (cells > 10 * static_cast<double>(places.size()) + 1000) {
    throw ReadError("expected traces on a lattice of inlines and crosslines, found " + std::to_string(places.size()) +
                    " traces for " + std::to_string(inlines.count) + " x " + std::to_string(crosslines.count) +
                    " places");
  }
  HostMemory memory(host);
  memory.take(survey.fast.count * survey.slow.count * sizeof(std::int32_t));
  fill_table(survey, places);
  if (survey.missing > 0) {
    survey.note += std::to_string(survey.missing) + " of " + std::to_string(survey.trace.size()) +
                   " traces are missing and have no data; ";
  }
  if (!place_by_coordinates(survey, places)) {
    survey.note += "the trace headers have no usable coordinates (bytes 181-188), so ";
    place_by_lines(survey);
  }
  memory.keep();
  return survey;
}

}  // namespace isoextract_segy
