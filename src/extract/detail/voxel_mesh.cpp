#include "extract/detail/voxel_mesh.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "base/stopwatch.hpp"
#include "extract/detail/face_rectangles.hpp"
#include "extract/detail/surface_points.hpp"
#include "extract/mesh_assembly.hpp"

namespace isoextract::extract {
namespace {

// Rectangles of one layer whose triangles are written one after the other.
struct Portion {
  int axis;
  std::span<const FaceRectangle> rectangles;
  std::uint64_t first_triangle = 0;
};
constexpr std::size_t kPortion = 4096;

// The outline of a rectangle as vertices, and the triangles between them.
//
//   top    T0-------T1----T2        The left side, from the top left down, makes a fan around B1, the second
//          |              |         vertex of the bottom. The right side, from the bottom right up, makes a fan
//   left   |              |  right  around T1, the last but one vertex of the top. The rest lies between two parallel
//          |              |         rows. No triangle has three vertices on one side, so none has zero area.
//   bottom B0--B1---------B2        There are two fewer triangles than vertices.
class OutlinePolygon {
 public:
  OutlinePolygon(const SurfacePoints& points, int axis, bool closes, bool mirrored)
      : finders_{SurfacePoints::Finder(points), SurfacePoints::Finder(points), SurfacePoints::Finder(points),
                 SurfacePoints::Finder(points)},
        axis_(axis),
        closes_(closes),
        mirrored_(mirrored) {}

  void look_up(const FaceRectangle& rectangle) {
    const int width = rectangle.high[0] - rectangle.low[0];
    const int height = rectangle.high[1] - rectangle.low[1];
    bottom_.clear();
    top_.clear();
    left_.clear();
    right_.clear();
    turn_for(rectangle);
    // Named by the ends of u and v: low_high is at the low end of u and the high end of v.
    const FaceCorner low_low = corner(rectangle, 0, 0);
    const FaceCorner high_low = corner(rectangle, 1, 0);
    const FaceCorner low_high = corner(rectangle, 0, 1);
    const FaceCorner high_high = corner(rectangle, 1, 1);
    const int voxel = rectangle.upward ? 0 : 1;  // side of the voxel across the plane
    // Returns the side of the voxel at a rectangle side (Finder::along()), along the lower one of two axes: the plane's
    // axis or `other_axis`.
    const auto upper = [&](int other_axis, int quadrant) { return axis_ < other_axis ? voxel : quadrant; };
    const int u = plane_u(axis_);
    const int v = plane_v(axis_);
    bottom_.push_back({finders_[0].vertex(low_low), 0});
    top_.push_back({finders_[2].vertex(low_high), 0});
    if (closes_) {
      finders_[0].along(low_low, u, width, upper(v, 1), [&](auto vertex, int at) { bottom_.push_back({vertex, at}); });
      finders_[2].along(low_high, u, width, upper(v, 0), [&](auto vertex, int at) { top_.push_back({vertex, at}); });
      finders_[3].along(low_low, v, height, upper(u, 1), [&](auto vertex, int at) { left_.push_back({vertex, at}); });
      finders_[1].along(high_low, v, height, upper(u, 0), [&](auto vertex, int at) { right_.push_back({vertex, at}); });
    }
    bottom_.push_back({finders_[1].vertex(high_low), 2 * width});
    top_.push_back({finders_[1].vertex(high_high), 2 * width});
  }

  // Returns the number of triangles of a face that write_bent() writes: two, and one for each middle vertex.
  [[nodiscard]] std::size_t count_bent(const FaceRectangle& face) {
    std::size_t count = 2;
    for_each_middle(face, [&](std::size_t /*side*/, std::uint32_t /*vertex*/) { ++count; });
    return count;
  }

  [[nodiscard]] std::size_t triangles() const {
    return bottom_.size() + top_.size() + left_.size() + right_.size() - 2;
  }

  // Writes a single face whose corners are not in a plane, as two halves with all middle vertices of its sides. Of the
  // two diagonals, it takes the one whose smaller half is larger. The label on the other side thus chooses the same
  // one, and no half has zero area: four points in the four quadrants around a grid edge always allow that.
  void write_bent(const FaceRectangle& face, const Buffer<glm::vec3>& positions, glm::uvec3*& out) {
    turn_for(face);
    const std::array<std::uint32_t, 4> around{
        finders_[0].vertex(corner(face, 0, 0)), finders_[1].vertex(corner(face, 1, 0)),
        finders_[3].vertex(corner(face, 1, 1)), finders_[2].vertex(corner(face, 0, 1))};
    std::array<std::optional<std::uint32_t>, 4> middles;  // of the sides, each after its corner in `around`
    if (closes_) for_each_middle(face, [&](std::size_t side, std::uint32_t vertex) { middles[side] = vertex; });
    const auto area = [&](std::size_t apex) {  // squared area of the half around corner `apex`
      const glm::dvec3 at(positions[around[apex]]);
      const glm::dvec3 normal = glm::cross(glm::dvec3(positions[around[(apex + 1) % 4]]) - at,
                                           glm::dvec3(positions[around[(apex + 3) % 4]]) - at);
      return glm::dot(normal, normal);
    };
    const std::size_t first = std::min(area(0), area(2)) < std::min(area(1), area(3)) ? 1 : 0;
    for (const std::size_t apex : {first, first + 2}) {
      const std::size_t before = (apex + 3) % 4;
      const std::uint32_t last = around[(apex + 1) % 4];
      std::uint32_t at = around[before];
      std::uint32_t from = around[apex];
      if (middles[before]) {
        put(at, *middles[before], last, out);
        at = *middles[before];
      }
      if (middles[apex]) {
        put(at, from, *middles[apex], out);
        from = *middles[apex];
      }
      put(at, from, last, out);
    }
  }

  void write(glm::uvec3*& out) const {
    const auto put = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) { this->put(a, b, c, out); };
    const std::uint32_t left_apex = bottom_[1].vertex;
    std::uint32_t last = top_.front().vertex;
    for (std::size_t l = left_.size(); l-- > 0;) {
      put(last, left_[l].vertex, left_apex);
      last = left_[l].vertex;
    }
    put(last, bottom_.front().vertex, left_apex);
    const std::size_t top_end = top_.size() - 2;
    const std::uint32_t right_apex = top_[top_end].vertex;
    last = bottom_.back().vertex;
    for (const Found& found : right_) {
      put(last, found.vertex, right_apex);
      last = found.vertex;
    }
    put(last, top_.back().vertex, right_apex);
    std::size_t b = 1;
    std::size_t t = 0;
    while (b + 1 < bottom_.size() || t < top_end) {
      const bool below = t == top_end || (b + 1 < bottom_.size() && bottom_[b + 1].at <= top_[t + 1].at);
      if (below) {
        put(bottom_[b].vertex, bottom_[b + 1].vertex, top_[t].vertex);
        ++b;
      } else {
        put(bottom_[b].vertex, top_[t + 1].vertex, top_[t].vertex);
        ++t;
      }
    }
  }

 private:
  struct Found {
    std::uint32_t vertex;
    int at;  // half steps along the side
  };

  // u x v points along the axis, except for planes across y.
  void turn_for(const FaceRectangle& rectangle) { turned_ = (rectangle.upward == (axis_ == 1)) != mirrored_; }

  // Calls f(side, vertex) for the vertices in the middle of the sides of a single face: bottom, right, top, left.
  template <class F>
  void for_each_middle(const FaceRectangle& face, const F& f) {
    const int voxel = face.upward ? 0 : 1;
    const auto upper = [&](int other_axis, int quadrant) { return axis_ < other_axis ? voxel : quadrant; };
    const auto of_side = [&](std::size_t side) { return [&f, side](auto vertex, int /*at*/) { f(side, vertex); }; };
    const int u = plane_u(axis_);
    const int v = plane_v(axis_);
    finders_[0].along(corner(face, 0, 0), u, 1, upper(v, 1), of_side(0));
    finders_[1].along(corner(face, 1, 0), v, 1, upper(u, 0), of_side(1));
    finders_[2].along(corner(face, 0, 1), u, 1, upper(v, 0), of_side(2));
    finders_[3].along(corner(face, 0, 0), v, 1, upper(u, 1), of_side(3));
  }

  void put(std::uint32_t a, std::uint32_t b, std::uint32_t c, glm::uvec3*& out) const {
    *out++ = turned_ ? glm::uvec3(a, c, b) : glm::uvec3(a, b, c);
  }

  // Returns the corner at the high (1) or low (0) end of u and v, and the number of the rectangle's face around it.
  [[nodiscard]] FaceCorner corner(const FaceRectangle& rectangle, int high_u, int high_v) const {
    FaceCorner found;
    found.corner[axis_] = rectangle.plane;
    found.corner[plane_u(axis_)] = high_u != 0 ? rectangle.high[0] : rectangle.low[0];
    found.corner[plane_v(axis_)] = high_v != 0 ? rectangle.high[1] : rectangle.low[1];
    found.face = axis_ * 4 + ((1 - high_u) | (1 - high_v) << 1);
    return found;
  }

  std::array<SurfacePoints::Finder, 4> finders_;  // each stays near its side
  int axis_;
  bool closes_;
  bool mirrored_;
  bool turned_ = false;
  std::vector<Found> bottom_;
  std::vector<Found> top_;
  std::vector<Found> left_;
  std::vector<Found> right_;
};

// Removes vertices without triangles, keeping the order of the others. If sides of rectangles pass through a corner, a
// fan there may have no rectangle that ends in it.
Result<void> drop_unused_vertices(mesh::Mesh& mesh, const Context& context, const std::string& what) {
  auto numbers = TRY(make_reserved_buffer<std::uint32_t>(mesh.positions.size(), context, what));
  Buffer<std::uint32_t>& number = numbers->values;
  std::fill(number.begin(), number.end(), 0U);
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int c = 0; c < 3; ++c) number[triangle[c]] = 1;
  }
  std::uint32_t used = 0;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] == 0) continue;
    mesh.positions[used] = mesh.positions[v];
    number[v] = used++;
  }
  if (used == number.size()) return {};
  for_each_index(mesh.triangles.size(), [&](std::size_t t) {
    glm::uvec3& triangle = mesh.triangles[t];
    triangle = {number[triangle.x], number[triangle.y], number[triangle.z]};
  });
  auto memory = context.reserve(used * sizeof(glm::vec3), what);  // both arrays exist while the positions are copied
  if (!memory) return tl::unexpected(memory.error());
  Buffer<glm::vec3> positions(used);
  std::copy_n(mesh.positions.begin(), used, positions.begin());
  mesh.positions = std::move(positions);
  mesh.memory.shrink(mesh.positions.size_bytes() + mesh.triangles.size_bytes());
  return {};
}

template <class F>
void for_each_portion(std::vector<Portion>& portions, const SurfacePoints& points, bool closes, bool mirrored,
                      const Context& context, const F& f) {
  for_each_index(portions.size(), [&](std::size_t p) {
    if (context.cancelled()) return;
    OutlinePolygon polygon(points, portions[p].axis, closes, mirrored);
    f(portions[p], polygon);
  });
}

std::vector<Portion> portions_of(const std::vector<LayerRectangles>& layers) {
  std::vector<Portion> portions;
  for (const LayerRectangles& layer : layers) {
    const std::span<const FaceRectangle> all = layer.rectangles.values();
    for (std::size_t begin = 0; begin < all.size(); begin += kPortion) {
      portions.push_back({layer.axis, all.subspan(begin, std::min(kPortion, all.size() - begin))});
    }
  }
  return portions;
}

}  // namespace

Result<Extraction> mesh_voxels(const field::ScalarField& field, const VoxelChunks& voxels, const glm::ivec3& base,
                               const OutputPlacement& placement, const ExtractOptions& options,
                               const ExtractStats& stats, const Context& context, const NetPoints* net) {
  Extraction result;
  result.stats = stats;
  result.mesh.origin = placement.origin();
  TRY(check_placement(field, placement));
  Stopwatch watch;
  const VoxelFaces faces = net != nullptr ? VoxelFaces::plain : options.voxel_faces;
  const bool closes = faces != VoxelFaces::rectangles;
  const std::string what = fmt::format("{}: the faces of its voxels", field.source);
  auto layers = TRY(list_face_rectangles(voxels, faces, context, what));
  auto points = TRY(SurfacePoints::make(voxels, layers, faces, net, context, what));

  // The sides of single faces have no vertices except those in their middles.
  const bool has_side_vertices = closes && (faces != VoxelFaces::plain || points.has_middles());
  std::vector<Portion> portions = portions_of(layers);
  const auto each = [&](const auto& f) {
    for_each_portion(portions, points, has_side_vertices, placement.mirrored(), context, f);
  };
  MeshSizes sizes{points.vertices(), 0};
  TRY(check_vertex_count(field, sizes));
  if (has_side_vertices) {
    each([&](Portion& portion, OutlinePolygon& polygon) {
      for (const FaceRectangle& rectangle : portion.rectangles) {
        if (net != nullptr) {
          portion.first_triangle += polygon.count_bent(rectangle);
          continue;
        }
        polygon.look_up(rectangle);
        portion.first_triangle += polygon.triangles();
      }
    });
  } else {
    for (Portion& portion : portions) portion.first_triangle = 2 * portion.rectangles.size();
  }
  for (Portion& portion : portions) sizes.triangles += std::exchange(portion.first_triangle, sizes.triangles);
  result.stats.count += watch.elapsed();
  TRY(context.check());

  watch.restart();
  auto memory = TRY(reserve_mesh(field, sizes, options, context));
  allocate_mesh(result.mesh, sizes, {}, options);
  context.progress().begin("extracting", 0);
  points.write_positions(placement, base, result.mesh);
  each([&](const Portion& portion, OutlinePolygon& polygon) {
    glm::uvec3* out = result.mesh.triangles.data() + portion.first_triangle;
    for (const FaceRectangle& rectangle : portion.rectangles) {
      if (net != nullptr) {
        polygon.write_bent(rectangle, result.mesh.positions, out);
        continue;
      }
      polygon.look_up(rectangle);
      polygon.write(out);
    }
  });
  TRY(context.check());
  result.mesh.memory = std::move(memory);
  if (!closes) {
    TRY(drop_unused_vertices(result.mesh, context, what));
  }
  result.stats.emit += watch.elapsed();
  return result;
}

}  // namespace isoextract::extract
