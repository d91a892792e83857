#include "mesh_io/write/coordinate_rounding.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "base/finite.hpp"
#include "base/parallel.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::mesh_io {
namespace {

constexpr double kMostChange = 0.25;
constexpr double kLargestFloat = std::numeric_limits<float>::max();

double largest(const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

// Returns the distance from a non-negative number to the next larger one of its type.
template <class Number>
double spacing(double size) {
  const auto number = static_cast<Number>(size);
  return static_cast<double>(std::nextafter(number, std::numeric_limits<Number>::infinity()) - number);
}

// Sums over triangles: lengths of normal vectors (twice the area), and of the changes of these vectors.
struct Change {
  double lengths = 0;
  double changes = 0;           // by rounding
  std::uint64_t collapsed = 0;  // triangles that rounding leaves with two corners at one place

  friend Change operator+(const Change& a, const Change& b) {
    return {a.lengths + b.lengths, a.changes + b.changes, a.collapsed + b.collapsed};
  }
};

template <class Number>
Change measure_change(const mesh::Mesh& mesh) {
  constexpr std::size_t kGrain = 1 << 15;
  constexpr std::size_t kAtATime = 256;
  return reduce_ranges(
      mesh.triangles.size(), kGrain, Change{},
      [&](std::size_t begin, std::size_t end, Change sum) {
        std::array<std::array<glm::vec<3, Number>, 3>, kAtATime> written;
        for (std::size_t first = begin; first < end; first += kAtATime) {
          const std::size_t last = std::min(first + kAtATime, end);
          // Rounds in a separate loop: if rounding and the conversion back to double share an expression, GCC 12 may
          // skip the rounding (-ftree-slp-vectorize).
          for (std::size_t t = first; t < last; ++t) {
            for (int c = 0; c < 3; ++c) {
              written[t - first][static_cast<std::size_t>(c)] =
                  glm::vec<3, Number>(mesh.position(mesh.triangles[t][c]));
            }
          }
          for (std::size_t t = first; t < last; ++t) {
            const auto vector = [](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
              return glm::cross(b - a, c - a);
            };
            const glm::uvec3& corners = mesh.triangles[t];
            const glm::dvec3 before =
                vector(mesh.positions[corners.x], mesh.positions[corners.y], mesh.positions[corners.z]);
            const auto& [a, b, c] = written[t - first];
            sum.lengths += glm::length(before);
            sum.changes += glm::length(vector(a, b, c) - before);
            if (a == b || b == c || c == a) ++sum.collapsed;
          }
        }
        return sum;
      },
      [](const Change& a, const Change& b) { return a + b; });
}

// The damage that a format does to a mesh: either a failure, as the sentence after the file's name, or the number of
// triangles that get two corners at the same coordinates.
struct Loss {
  std::string failure;
  std::uint64_t collapsed = 0;
};

template <class Number>
Loss loss_in(const mesh::Mesh& mesh, std::string_view type) {
  const mesh::LocalBounds local = mesh::measure_local_bounds(mesh);
  const mesh::Bounds world{mesh.origin + glm::dvec3(local.min), mesh.origin + glm::dvec3(local.max)};
  const double farthest = std::max(largest(world.min), largest(world.max));
  if (farthest > static_cast<double>(std::numeric_limits<Number>::max())) {
    return {fmt::format("expected coordinates in the range of {}, found {:.6g}", type, farthest)};
  }
  const double step = spacing<Number>(farthest);
  if (step <= spacing<float>(std::max(largest(local.min), largest(local.max)))) return {};
  const Change change = measure_change<Number>(mesh);
  if (change.lengths == 0 || change.changes <= kMostChange * change.lengths) return {{}, change.collapsed};
  return {fmt::format(
      "expected coordinates that keep the corners of triangles distinct; at {:.6g}, coordinates of type {} are {:.3g} "
      "apart, and the triangles are about {:.3g} wide",
      farthest, type, step, std::sqrt(change.lengths / static_cast<double>(mesh.triangles.size())))};
}

Loss loss_in(const mesh::Mesh& mesh, MeshFormat format) {
  if (mesh.triangles.empty() || mesh.origin == glm::dvec3(0)) return {};
  if (!is_finite(mesh.origin)) {
    return {fmt::format("expected a finite origin of the mesh, found ({}, {}, {})", mesh.origin.x, mesh.origin.y,
                        mesh.origin.z)};
  }
  if (mesh_format_info(format).stores_float32_world) return loss_in<float>(mesh, "float32");
  if (is_gltf(format) && largest(mesh.origin) > kLargestFloat) {
    return {fmt::format("expected a node translation in the range of float32, found {:.6g}", largest(mesh.origin))};
  }
  return loss_in<double>(mesh, "double");
}

}  // namespace

Result<std::uint64_t> check_coordinate_rounding(const mesh::Mesh& mesh, const std::filesystem::path& path,
                                                MeshFormat format) {
  const Loss loss = loss_in(mesh, format);
  if (loss.failure.empty()) return loss.collapsed;
  std::string others;
  for (const MeshFormatInfo& info : mesh_formats()) {
    if (loss_in(mesh, info.format).failure.empty()) {
      others += fmt::format("{}{}", others.empty() ? "" : ", ", info.name);
    }
  }
  const Step nearer(Remedy::use, Setting::position);
  return fail(ErrorCode::output, fmt::format("{}: {}", path.string(), loss.failure),
              others.empty() ? Hint{nearer} : Hint{{Remedy::set, Setting::mesh_format, others}, nearer});
}

Note rounding_note(const std::filesystem::path& path, std::uint64_t collapsed, std::uint64_t triangles) {
  return {
      NoteId::rounded_positions,
      fmt::format("{}: in {} of {} triangles, corners round to equal positions in the file, whose coordinates are too "
                  "coarse so far from the origin",
                  path.string(), collapsed, triangles)};
}

}  // namespace isoextract::mesh_io
