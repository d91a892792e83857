#include "extract/inner_wall.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "extract/extractor.hpp"
#include "mesh/components.hpp"
#include "mesh/metrics.hpp"
#include "mesh/shells.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::extract {
namespace {

constexpr int kBlock = field::SparseBlock::kSize;
constexpr std::size_t kSamplesOfBlock = std::size_t{kBlock} * kBlock * kBlock;
constexpr double kMostCells = 1 << 24;
constexpr double kDiagonal = std::numbers::sqrt3;
// The least distance of a vertex from the ends of its grid edge, as a fraction of the edge. Keeps vertices apart.
constexpr double kLeastPart = 1e-3;

// The grid around the mesh, in the mesh's local coordinates (relative to mesh.origin). Measures exact distances.
class WallGrid {
 public:
  WallGrid(const mesh::Mesh& outer, const WallOptions& options, const mesh::LocalBounds& bounds)
      : tree_(outer.positions.span(), outer.triangles.span()),
        options_(options),
        corner_(glm::dvec3(bounds.min) - (options.thickness + 3 * options.cell)) {}

  [[nodiscard]] const mesh::TriangleTree& tree() const { return tree_; }
  [[nodiscard]] glm::dvec3 at(const glm::dvec3& index) const { return corner_ + options_.cell * index; }
  [[nodiscard]] double distance(const glm::dvec3& p, std::uint32_t& hint) const {
    const mesh::TriangleTree::Nearest nearest = tree_.nearest(p, hint);
    hint = nearest.slot;
    return std::sqrt(nearest.distance_squared);
  }
  [[nodiscard]] field::Affine index_to_frame() const {
    field::Affine map = field::scaling(glm::dvec3(options_.cell));
    map.offset = corner_;
    return map;
  }
  // Returns the distance for samples far from the mesh; above the thickness.
  [[nodiscard]] double background() const { return 2 * options_.thickness + options_.cell; }

  enum class Side : std::uint8_t { nearer, farther, both };
  // Returns whether all samples of the cube and their neighbors are nearer or farther than the thickness; `both` if
  // that is not certain. `found` gets the distance at the cube's center.
  [[nodiscard]] Side side_of(const glm::ivec3& origin, int size, std::uint32_t& hint, double& found) const {
    const double half = (size - 1) / 2.0;
    const double reach = kDiagonal * options_.cell * (half + 1);
    found = distance(at(glm::dvec3(origin) + half), hint);
    if (found - options_.thickness > reach) return Side::farther;
    return options_.thickness - found > reach ? Side::nearer : Side::both;
  }

  // Fills the samples of a cube in a block. Samples whose edges do not cross the thickness get any value on their side.
  void fill(float* block, const glm::ivec3& origin, const glm::ivec3& in_block, int size, std::uint32_t& hint) const {
    double found = 0;
    const Side side = side_of(origin + in_block, size, hint, found);
    if (side == Side::both && size > 1) {
      const int half = size / 2;
      for (int child = 0; child < 8; ++child) {
        fill(block, origin, in_block + half * glm::ivec3(child >> 2, child >> 1 & 1, child & 1), half, hint);
      }
      return;
    }
    const auto value = static_cast<float>(side == Side::both ? found : side == Side::nearer ? 0 : background());
    for (int x = in_block.x; x < in_block.x + size; ++x) {
      for (int y = in_block.y; y < in_block.y + size; ++y) {
        for (int z = in_block.z; z < in_block.z + size; ++z) block[x << 6 | y << 3 | z] = value;
      }
    }
  }

  // Returns the point of a grid edge whose distance is the thickness, by the Illinois variant of regula falsi.
  [[nodiscard]] glm::dvec3 crossing(const mesh::EdgeKey& edge, std::uint32_t& hint) const {
    const glm::dvec3 low(edge.low);
    const glm::dvec3 along(edge.direction & 1, edge.direction >> 1 & 1, edge.direction >> 2 & 1);
    const auto excess = [&](double part) { return distance(at(low + part * along), hint) - options_.thickness; };
    double a = 0;
    double b = 1;
    double at_a = excess(a);
    double at_b = excess(b);
    double part = std::abs(at_a) < std::abs(at_b) ? a : b;  // if rounding hides the crossing
    constexpr int kMostSteps = 40;
    for (int step = 0; step < kMostSteps && (at_a < 0) != (at_b < 0); ++step) {
      part = (a * at_b - b * at_a) / (at_b - at_a);
      const double here = excess(part);
      if (std::abs(here) <= 1e-7 * options_.thickness) break;
      if ((here < 0) == (at_b < 0)) {
        at_a *= 0.5;
      } else {
        a = b;
        at_a = at_b;
      }
      b = part;
      at_b = here;
    }
    return at(low + std::clamp(part, kLeastPart, 1 - kLeastPart) * along);
  }

 private:
  mesh::TriangleTree tree_;
  WallOptions options_;
  glm::dvec3 corner_;
};

struct Band {
  std::vector<glm::ivec3> blocks;  // may have points at the thickness
  std::vector<field::SparseTile> tiles;
};

// Finds the blocks by dividing cubes, the largest first. `size` is the side of the first cube, in samples.
Result<Band> find_band(const WallGrid& grid, int size, const std::string& what, const Context& context) {
  Band band;
  std::vector<glm::ivec3> cubes{glm::ivec3(0)};
  for (;; size /= 2) {
    TRY(context.check());
    const auto memory = TRY(context.reserve(cubes.size() * (sizeof(glm::ivec3) + 1) * 9, what));
    std::vector<WallGrid::Side> sides(cubes.size());
    constexpr std::size_t kGrain = 64;
    for_each_range(cubes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      std::uint32_t hint = 0;
      double found = 0;
      for (std::size_t c = begin; c < end; ++c) sides[c] = grid.side_of(cubes[c], size, hint, found);
    });
    std::vector<glm::ivec3> next;
    for (std::size_t c = 0; c < cubes.size(); ++c) {
      if (sides[c] == WallGrid::Side::nearer) band.tiles.push_back({cubes[c], size, 0});
      if (sides[c] != WallGrid::Side::both) continue;
      if (size == kBlock) {
        next.push_back(cubes[c]);
        continue;
      }
      for (int child = 0; child < 8; ++child) {
        next.push_back(cubes[c] + size / 2 * glm::ivec3(child >> 2, child >> 1 & 1, child & 1));
      }
    }
    cubes = std::move(next);
    if (size == kBlock) break;
  }
  band.blocks = std::move(cubes);
  std::ranges::sort(band.blocks, {}, [](const glm::ivec3& o) { return std::tuple(o.x, o.y, o.z); });
  return band;
}

// Extracts the surface of all points at the thickness from the mesh, inside and outside the mesh.
Result<mesh::Mesh> extract_offset(const WallGrid& grid, Band band, double thickness, const std::string& what,
                                  const Context& context) {
  const auto values = TRY(make_reserved_buffer<float>(band.blocks.size() * kSamplesOfBlock, context, what));
  field::ScalarField field;
  field.name = what;
  field.source = what;
  field.kind = field::FieldKind::level_set;
  field.index_to_world = grid.index_to_frame();
  field::SparseSamples samples;
  samples.tiles = std::move(band.tiles);
  samples.background = static_cast<double>(static_cast<float>(grid.background()));
  samples.blocks.resize(band.blocks.size());
  for_each_range(band.blocks.size(), 1, [&](std::size_t begin, std::size_t end) {
    std::uint32_t hint = 0;
    for (std::size_t b = begin; b < end; ++b) {
      float* const block = values->values.data() + b * kSamplesOfBlock;
      grid.fill(block, band.blocks[b], glm::ivec3(0), kBlock, hint);
      samples.blocks[b] = {band.blocks[b], block};
    }
  });
  samples.active_voxels = band.blocks.size() * kSamplesOfBlock;
  if (!band.blocks.empty()) samples.active_box = {band.blocks.front(), band.blocks.front() + (kBlock - 1)};
  for (const glm::ivec3& origin : band.blocks) {
    samples.active_box.min = glm::min(samples.active_box.min, origin);
    samples.active_box.max = glm::max(samples.active_box.max, origin + (kBlock - 1));
  }
  field.samples = std::move(samples);
  ExtractOptions options;
  options.iso = thickness;
  options.edge_keys = true;
  options.output_from_index = field.index_to_world;
  return std::move(TRY(make_cpu_extractor()->extract(field, options, context)).mesh);
}

// Returns for each vertex of `offset` whether its component lies in the material of `outer`. Counts these components.
Result<std::vector<bool>> in_material(const mesh::Mesh& outer, const mesh::Mesh& offset, WallFigures& facts,
                                      const Context& context) {
  const std::size_t first = outer.positions.size();
  mesh::Mesh both;
  both.name = outer.name;
  both.memory = TRY(context.reserve((first + offset.positions.size()) * (sizeof(glm::vec3) + sizeof(std::uint32_t)) +
                                        (outer.triangles.size() + offset.triangles.size()) * sizeof(glm::uvec3),
                                    outer.name + ": shells of its inner wall"));
  both.positions = Buffer<glm::vec3>(first + offset.positions.size());
  std::ranges::copy(outer.positions.span(), both.positions.begin());
  for (std::size_t v = 0; v < offset.positions.size(); ++v) both.positions[first + v] = glm::vec3(offset.position(v));
  both.triangles = Buffer<glm::uvec3>(outer.triangles.size() + offset.triangles.size());
  std::ranges::copy(outer.triangles.span(), both.triangles.begin());
  std::ranges::transform(offset.triangles.span(), both.triangles.begin() + outer.triangles.size(),
                         [&](const glm::uvec3& t) { return t + static_cast<std::uint32_t>(first); });
  const mesh::Components components(both.triangles.span(), both.positions.size());
  std::vector<double> volumes(components.count());
  const glm::dvec3 middle(both.positions[0]);
  for (const glm::uvec3& t : both.triangles) {
    const std::uint32_t component = components.of_vertex(t.x);
    if (component == mesh::Components::kNone) continue;
    const glm::dvec3 a = glm::dvec3(both.positions[t.x]) - middle;
    const glm::dvec3 b = glm::dvec3(both.positions[t.y]) - middle;
    volumes[component] += glm::dot(a, glm::cross(b, glm::dvec3(both.positions[t.z]) - middle));
  }
  std::uint32_t outer_count = 0;
  for (std::size_t v = 0; v < first; ++v) {
    const std::uint32_t component = components.of_vertex(v);
    if (component != mesh::Components::kNone) outer_count = std::max(outer_count, component + 1);
  }
  mesh::ShellQuery question;
  for (const double volume : volumes) {
    question.facing.push_back(volume < 0 ? mesh::Facing::inward : mesh::Facing::outward);
  }
  const auto surroundings = TRY(mesh::find_enclosing_shells(both, components, question, context));
  std::vector<bool> keeps(components.count(), false);
  for (std::size_t c = outer_count; c < components.count(); ++c) {
    int winding = 0;
    for (const std::uint32_t shell : surroundings[c].around) {
      if (shell < outer_count) winding += question.facing[shell] == mesh::Facing::inward ? -1 : 1;
    }
    keeps[c] = winding > 0;
    if (keeps[c]) ++(question.facing[c] == mesh::Facing::inward ? facts.cavities : facts.loose_walls);
  }
  std::vector<bool> result(offset.positions.size(), false);
  for (std::size_t v = 0; v < result.size(); ++v) {
    const std::uint32_t component = components.of_vertex(first + v);
    result[v] = component != mesh::Components::kNone && keeps[component];
  }
  return result;
}

// Returns the triangles of `offset` between vertices in `chosen`, with the vertices moved to the exact thickness.
InnerWall wall_of(const mesh::Mesh& outer, const mesh::Mesh& offset, const std::vector<bool>& chosen,
                  const WallGrid& grid) {
  std::vector<std::uint32_t> old_of_new;
  Buffer<std::uint32_t> new_of_old(offset.positions.size());
  for (std::size_t v = 0; v < chosen.size(); ++v) {
    new_of_old[v] = static_cast<std::uint32_t>(old_of_new.size());
    if (chosen[v]) old_of_new.push_back(static_cast<std::uint32_t>(v));
  }
  InnerWall wall;
  wall.mesh.name = outer.name;
  wall.mesh.origin = outer.origin;
  wall.mesh.positions = Buffer<glm::vec3>(old_of_new.size());
  if (!outer.normals.empty()) wall.mesh.normals = Buffer<glm::vec3>(old_of_new.size());
  wall.nearest_vertices = Buffer<std::uint32_t>(old_of_new.size());
  constexpr std::size_t kGrain = 256;
  for_each_range(old_of_new.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::uint32_t hint = 0;
    for (std::size_t v = begin; v < end; ++v) {
      const glm::dvec3 p = grid.crossing(offset.edges[old_of_new[v]], hint);
      wall.mesh.positions[v] = glm::vec3(p);
      const mesh::TriangleTree::Nearest nearest = grid.tree().nearest(p, hint);
      if (!outer.normals.empty()) wall.mesh.normals[v] = glm::vec3(glm::normalize(p - nearest.point));
      const glm::uvec3 t = outer.triangles[grid.tree().triangle(nearest.slot)];
      const auto distance = [&](int corner) {
        return glm::distance(glm::dvec3(outer.positions[t[corner]]), nearest.point);
      };
      const int closest = distance(0) <= std::min(distance(1), distance(2)) ? 0 : distance(1) <= distance(2) ? 1 : 2;
      wall.nearest_vertices[v] = t[closest];
    }
  });
  std::vector<glm::uvec3> triangles;
  for (const glm::uvec3& t : offset.triangles) {
    if (chosen[t.x]) triangles.emplace_back(new_of_old[t.x], new_of_old[t.y], new_of_old[t.z]);
  }
  wall.mesh.triangles = Buffer<glm::uvec3>(triangles.size());
  std::ranges::copy(triangles, wall.mesh.triangles.begin());
  return wall;
}

void measure(const WallGrid& grid, double thickness, InnerWall& wall) {
  struct Measured {
    double least = std::numeric_limits<double>::infinity();
    double most = 0;
    double squares = 0;
  };
  const mesh::Mesh& mesh = wall.mesh;
  if (mesh.triangles.empty()) return;
  const auto look = [&](std::size_t begin, std::size_t end, Measured found) {
    std::uint32_t hint = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const glm::uvec3 t = mesh.triangles[i];
      const glm::dvec3 a(mesh.positions[t.x]);
      const glm::dvec3 b(mesh.positions[t.y]);
      const glm::dvec3 c(mesh.positions[t.z]);
      for (const glm::dvec3& p : {(a + b + c) / 3.0, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0}) {
        const double distance = grid.distance(p, hint);
        found.least = std::min(found.least, distance);
        found.most = std::max(found.most, distance);
        found.squares += (distance - thickness) * (distance - thickness);
      }
    }
    return found;
  };
  constexpr std::size_t kGrain = 256;
  const Measured all =
      reduce_ranges(mesh.triangles.size(), kGrain, Measured(), look, [](const Measured& a, const Measured& b) {
        return Measured{std::min(a.least, b.least), std::max(a.most, b.most), a.squares + b.squares};
      });
  wall.figures.thinnest = all.least;
  wall.figures.thickest = all.most;
  wall.figures.rms_difference = std::sqrt(all.squares / (4.0 * static_cast<double>(mesh.triangles.size())));
}

}  // namespace

Result<InnerWall> make_inner_wall(const mesh::Mesh& outer, const WallOptions& options, const Context& context) {
  if (outer.triangles.empty()) return InnerWall();
  const std::string what = outer.name + ": its inner wall";
  const mesh::LocalBounds bounds = mesh::measure_local_bounds(outer);
  const glm::dvec3 extent = glm::dvec3(bounds.max) - glm::dvec3(bounds.min);
  const double cells = (std::max({extent.x, extent.y, extent.z}) + 2 * options.thickness) / options.cell + 8;
  if (!(cells <= kMostCells)) {
    return fail(
        ErrorCode::input,
        fmt::format("{}: a wall of {:.4g} is too thin for a surface of {:.4g} x {:.4g} x {:.4g}: the grid of distances "
                    "to the surface would have more than 2^24 cells along an axis",
                    outer.name, options.thickness, extent.x, extent.y, extent.z),
        {Remedy::raise, Setting::hollow});
  }
  // A wall point has the surface at least one thickness away on both sides along each axis, within the bounding box.
  if (2 * options.thickness > std::min({extent.x, extent.y, extent.z})) return InnerWall();
  context.progress().begin("hollowing", 0);
  const auto tree_memory = TRY(context.reserve(mesh::TriangleTree::bytes(outer.triangles.size()), what));
  const WallGrid grid(outer, options, bounds);
  const int size =
      static_cast<int>(std::max<std::uint32_t>(kBlock, std::bit_ceil(static_cast<std::uint32_t>(cells) + 1)));
  const mesh::Mesh offset =
      TRY(extract_offset(grid, TRY(find_band(grid, size, what, context)), options.thickness, what, context));
  TRY(context.check());
  WallFigures facts;
  const std::vector<bool> chosen = TRY(in_material(outer, offset, facts, context));
  constexpr std::uint64_t kVertexBytes = 2 * sizeof(glm::vec3) + 3 * sizeof(std::uint32_t);
  constexpr std::uint64_t kTriangleBytes = 2 * sizeof(glm::uvec3);
  auto memory =
      TRY(context.reserve(offset.positions.size() * kVertexBytes + offset.triangles.size() * kTriangleBytes, what));
  InnerWall wall = wall_of(outer, offset, chosen, grid);
  wall.figures = facts;
  measure(grid, options.thickness, wall);
  wall.mesh.memory = std::move(memory);
  return wall;
}

std::uint64_t estimated_wall_bytes(std::uint64_t triangles, double area, double cell) {
  // The surface of extract_offset() crosses about area / cell^2 cells on each side of the mesh, about 60 in a block.
  // Marching cubes makes about one vertex for each of these cells.
  const double cells = 2 * area / (cell * cell);
  constexpr double kCellBytes = kSamplesOfBlock * sizeof(float) / 60.0 + 150;
  return mesh::TriangleTree::bytes(triangles) + static_cast<std::uint64_t>(std::min(cells * kCellBytes, 0x1p62));
}

}  // namespace isoextract::extract
