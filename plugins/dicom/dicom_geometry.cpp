// Places slices: normals, distances along them, and the transforms of samples.
#include <algorithm>
#include <cmath>

#include "dicom_parts.hpp"

namespace isoextract_dicom {

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

double length(const Vector& a) { return std::sqrt(dot(a, a)); }

bool same_shape(const Frame& a, const Frame& b) {
  const auto near = [](double x, double y) { return std::abs(x - y) <= 1e-4 * std::max(std::abs(x), std::abs(y)); };
  const auto parallel = [](const Vector& x, const Vector& y) { return length(minus(x, y)) < 1e-3; };
  return a.has_position == b.has_position && a.has_orientation == b.has_orientation && a.has_spacing == b.has_spacing &&
         near(a.row_distance, b.row_distance) && near(a.column_distance, b.column_distance) &&
         parallel(a.row_direction, b.row_direction) && parallel(a.column_direction, b.column_direction);
}

std::array<double, 12> index_to_world(const Frame& frame, const Vector& origin, const Vector& step) {
  std::array<double, 12> rows{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    rows[axis * 4] = frame.row_direction[axis] * frame.column_distance;
    rows[axis * 4 + 1] = frame.column_direction[axis] * frame.row_distance;
    rows[axis * 4 + 2] = step[axis];
    rows[axis * 4 + 3] = origin[axis];
  }
  return rows;
}

namespace {

// Returns text with the range of the distances between neighbors, and those that differ from the median.
std::string describe_distances(const std::vector<double>& distances) {
  std::vector<double> sorted = distances;
  std::ranges::sort(sorted);
  const double usual = sorted[sorted.size() / 2];
  std::string text = "found distances from " + number_text(sorted.front()) + " to " + number_text(sorted.back()) +
                     " mm, usually " + number_text(usual) + " mm";
  std::size_t shown = 0;
  std::size_t missing = 0;
  for (std::size_t i = 0; i < distances.size(); ++i) {
    if (std::abs(distances[i] - usual) <= 0.01 * usual) continue;
    const double steps = distances[i] / usual;
    if (steps > 1.5 && std::abs(steps - std::round(steps)) < 0.02)
      missing += static_cast<std::size_t>(std::llround(std::min(steps, 1e6))) - 1;
    constexpr std::size_t kMostShown = 5;
    if (shown < kMostShown) {
      text += (shown == 0 ? ": " : ", ") + number_text(distances[i]) + " mm after slice " + std::to_string(i + 1);
    } else if (shown == kMostShown) {
      text += ", ...";
    }
    ++shown;
  }
  if (missing > 0)
    text += "; by the usual distance " + std::to_string(missing) + (missing == 1 ? " slice is" : " slices are") +
            " missing";
  return text;
}

// Returns the largest distance between positions[i] and its lattice point, positions[0] + numbers[i] * step.
double largest_error(const std::vector<Vector>& positions, const Vector& step, const std::vector<double>& numbers) {
  double largest = 0;
  for (std::size_t i = 0; i < positions.size(); ++i)
    largest = std::max(largest, length(minus(positions[i], plus(positions[0], step, numbers[i]))));
  return largest;
}

}  // namespace

Line fit_line(const std::vector<Vector>& positions, const Frame& shape, bool resamples) {
  Line line;
  line.origin = positions.front();
  line.count = positions.size();
  const Vector normal = normal_of(shape);
  if (positions.size() < 2) {
    const double distance = shape.slice_distance > 0 ? shape.slice_distance : shape.thickness > 0 ? shape.thickness : 1;
    line.step = plus({0, 0, 0}, normal, distance);
    return line;
  }
  const auto last = static_cast<double>(positions.size() - 1);
  const Vector whole = minus(positions.back(), positions.front());
  line.step = plus({0, 0, 0}, whole, 1 / last);
  std::vector<double> numbers(positions.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<double>(i);
  // Tolerates a hundredth of a step, because headers have rounded positions.
  const double tolerance = 0.01 * dot(line.step, normal);
  if (largest_error(positions, line.step, numbers) <= tolerance) return line;

  std::vector<double> along(positions.size());
  std::vector<double> distances;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    along[i] = dot(minus(positions[i], positions[0]), whole) / dot(whole, whole);  // 0 to 1
    if (i > 0) distances.push_back(dot(minus(positions[i], positions[i - 1]), normal));
  }
  const double off_line = largest_error(positions, whole, along);
  if (off_line > std::max(tolerance, 0.1 * std::min(shape.column_distance, shape.row_distance))) {
    line.problem = "expected slices along a straight line, found one " + number_text(off_line) +
                   " mm beside the line from the first to the last";
    return line;
  }
  if (!resamples) {
    line.is_uneven = true;
    line.problem = "expected evenly spaced slices, " + describe_distances(distances);
    return line;
  }
  const double smallest = *std::ranges::min_element(distances);
  const double height = dot(whole, normal);
  constexpr double kMostTimes = 8;
  const double intervals = std::min(std::ceil(height / smallest - 0.01), kMostTimes * last);
  line.count = static_cast<std::size_t>(intervals) + 1;
  line.step = plus({0, 0, 0}, whole, 1 / intervals);
  std::size_t below = 0;
  for (std::size_t k = 0; k < line.count; ++k) {
    const double at = static_cast<double>(k) / intervals;
    while (below + 2 < along.size() && along[below + 1] <= at) ++below;
    const double part = (at - along[below]) / (along[below + 1] - along[below]);
    line.slice_positions.push_back(static_cast<double>(below) + std::clamp(part, 0.0, 1.0));
  }
  line.note = "the reader interpolates " + std::to_string(positions.size()) + " slices at distances of " +
              number_text(smallest) + " to " + number_text(*std::ranges::max_element(distances)) +
              " mm linearly, and makes " + std::to_string(line.count) + " slices every " +
              number_text(height / intervals) + " mm";
  return line;
}

}  // namespace isoextract_dicom
