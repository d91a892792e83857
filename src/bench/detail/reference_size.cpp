#include "bench/detail/reference_size.hpp"

#include <array>
#include <cmath>

#include "accuracy/crossing.hpp"
#include "base/reduction.hpp"

namespace isoextract::bench {
namespace {

constexpr int kSteps = 128;  // per line, to bracket roots
constexpr int kFaceLines = 4096;

struct ColumnSums {
  double area = 0;
  double flux = 0;  // outward flux of p

  void merge(const ColumnSums& other) {
    area += other.area;
    flux += other.flux;
  }
};

struct LengthSum {
  double length = 0;

  void merge(const LengthSum& other) { length += other.length; }
};

// Calls root(s, rising) for each s in [-1, 1] where at(s) crosses 0, in order. Returns whether at(-1) > 0.
template <class F, class Root>
bool find_roots(const F& at, const Root& root) {
  const double first = at(-1);
  double value = first;
  for (int step = 1; step <= kSteps; ++step) {
    const double from = -1 + 2.0 * (step - 1) / kSteps;
    const double to = -1 + 2.0 * step / kSteps;
    const double next = at(to);
    if ((value > 0) != (next > 0)) root(accuracy::find_crossing(at, from, value, to, next, 1e-13), next > 0);
    value = next;
  }
  return first > 0;
}

double center(int i, int count) { return -1 + (2 * i + 1.0) / count; }

class Columns {
 public:
  Columns(const field::AnalyticField& field, double iso, int count) : field_(field), iso_(iso), count_(count) {}

  [[nodiscard]] field::SurfaceSize integrate() const {
    const auto columns = static_cast<std::size_t>(count_) * static_cast<std::size_t>(count_);
    ColumnSums surface;
    LengthSum faces;
    for (int axis = 0; axis < 3; ++axis) {
      surface.merge(reduce_in_order(columns, ColumnSums{}, nullptr, [&](const PointRange& range, ColumnSums& sums) {
        for (std::size_t c = range.begin(); c != range.end(); ++c) {
          const int column = static_cast<int>(c);
          add_column(axis, center(column % count_, count_), center(column / count_, count_), sums);
        }
      }));
      if (field_.inside_length_along_z != nullptr) continue;
      for (const double side : {-1.0, 1.0}) {
        faces.merge(reduce_in_order(kFaceLines, LengthSum{}, nullptr, [&](const PointRange& range, LengthSum& sums) {
          for (std::size_t l = range.begin(); l != range.end(); ++l) {
            sums.length += length_above(axis, side, center(static_cast<int>(l), kFaceLines));
          }
        }));
      }
    }
    const double square = 4.0 / count_ / count_;
    return {surface.area * square, (surface.flux * square + faces.length * 2 / kFaceLines) / 3};
  }

 private:
  void add_column(int axis, double u, double v, ColumnSums& sums) const {
    glm::dvec3 p;
    p[(axis + 1) % 3] = u;
    p[(axis + 2) % 3] = v;
    const auto at = [&](double s) {
      p[axis] = s;
      return field_.value(p) - iso_;
    };
    find_roots(at, [&](double s, bool) {
      p[axis] = s;
      const glm::dvec3 gradient = field_.value_and_gradient(p).gradient;
      const double length = glm::length(gradient);
      if (!(length > 0)) return;
      const glm::dvec3 n = gradient / length;
      const glm::dvec3 squared = n * n;
      const glm::dvec3 eighth = squared * squared * squared * squared;
      const double share = eighth[axis] / (eighth.x + eighth.y + eighth.z);
      if (!(share > 0)) return;
      const double area = share / std::abs(n[axis]);
      sums.area += area;
      sums.flux -= area * glm::dot(p, n);  // values fall outward
    });
  }

  // Returns the length above iso of one line in a face of the cube.
  [[nodiscard]] double length_above(int axis, double side, double u) const {
    glm::dvec3 p;
    p[axis] = side;
    p[(axis + 1) % 3] = u;
    const auto at = [&](double s) {
      p[(axis + 2) % 3] = s;
      return field_.value(p) - iso_;
    };
    double length = 0;
    if (at(1) > 0) length += 1;
    // Adds the segments between a rising and a falling root, or the ends -1 and 1.
    if (find_roots(at, [&](double s, bool rising) { length += rising ? -s : s; })) length += 1;
    return length;
  }

  const field::AnalyticField& field_;
  double iso_;
  int count_;
};

// Integrates the columns along z with the field's closed forms.
field::SurfaceSize integrate_known_columns(const field::AnalyticField& field, double iso, int count) {
  struct Sums {
    field::SurfaceSize size;
    void merge(const Sums& other) {
      size.area += other.size.area;
      size.volume += other.size.volume;
    }
  };
  const auto lines = static_cast<std::size_t>(count);
  const auto sum = reduce_in_order(lines * lines, Sums{}, nullptr, [&](const PointRange& range, Sums& sums) {
    for (std::size_t l = range.begin(); l != range.end(); ++l) {
      const int line = static_cast<int>(l);
      const double x = center(line % count, count);
      const double y = center(line / count, count);
      const double length = field.inside_length_along_z(x, y, iso);
      sums.size.volume += length;
      if (!field.is_graph_over_z || length <= 0 || length >= 2) continue;
      const glm::dvec3 gradient = field.value_and_gradient({x, y, length - 1}).gradient;
      sums.size.area += glm::length(gradient) / std::abs(gradient.z);
    }
  });
  const double square = 4.0 / count / count;
  return {sum.size.area * square, sum.size.volume * square};
}

// Returns the change from doubling the columns.
field::SurfaceSize change(const field::SurfaceSize& a, const field::SurfaceSize& b) {
  return {std::abs(a.area - b.area), std::abs(a.volume - b.volume)};
}

ReferenceSize integrate_columns(const field::AnalyticField& field, double iso) {
  constexpr int kMaxColumns = 384;
  constexpr double kEnough = 5e-4;
  int columns = 96;
  ReferenceSize result{Columns(field, iso, columns).integrate(), false, {}};
  do {
    columns *= 2;
    const field::SurfaceSize finer = Columns(field, iso, columns).integrate();
    result.uncertainty = change(finer, result.size);
    result.size = finer;
  } while (result.uncertainty.area > kEnough * result.size.area && columns < kMaxColumns);
  return result;
}

}  // namespace

ReferenceSize find_reference_size(const field::AnalyticField& field, double iso, Progress* progress) {
  if (const auto size = field.size(iso)) return {*size, true, {}};
  if (progress != nullptr) progress->begin("finding the true size", 0);
  if (field.inside_length_along_z == nullptr) return integrate_columns(field, iso);
  // Odd numbers, so that periods of the field do not repeat the same columns.
  const field::SurfaceSize coarse = integrate_known_columns(field, iso, 1023);
  ReferenceSize known{integrate_known_columns(field, iso, 2047), false, {}};
  known.uncertainty = change(known.size, coarse);
  if (field.is_graph_over_z) return known;
  const ReferenceSize folded = integrate_columns(field, iso);
  known.size.area = folded.size.area;
  known.uncertainty.area = folded.uncertainty.area;
  return known;
}

}  // namespace isoextract::bench
