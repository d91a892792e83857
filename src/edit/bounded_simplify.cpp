#include "edit/bounded_simplify.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>
#include <tbb/partitioner.h>

#include "base/hash.hpp"
#include "edit/detail/patch_simplifier.hpp"
#include "mesh/distance_bound.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::edit {
namespace {

using Triangles = std::vector<glm::uvec3>;

// What is known of one triangle's distance to the other surface.
struct Known {
  double lower = 0;
  double upper = 0;
};

struct Box {
  glm::dvec3 min{std::numeric_limits<double>::infinity()};
  glm::dvec3 max{-std::numeric_limits<double>::infinity()};

  void add(const glm::dvec3& p) {
    min = glm::min(min, p);
    max = glm::max(max, p);
  }
  [[nodiscard]] bool overlaps(const Box& other, double gap) const {
    return glm::all(glm::lessThanEqual(min - gap, other.max)) && glm::all(glm::lessThanEqual(other.min - gap, max));
  }
};

struct Patch {
  std::vector<Face> before;
  std::vector<Known> known_before;  // of their distance to the mesh that came in
  std::vector<Face> after;
  std::vector<Known> known_after;
  Box box;                // of all vertices of `before`, which has those of `after`
  std::vector<Box> held;  // where triangles stay as they were, for something would be too far from them
  bool pending = true;    // to be simplified, or simplified again
  [[nodiscard]] bool changed() const { return before.size() != after.size(); }
  void keep() {
    after = before;
    known_after = known_before;
    pending = false;
  }
};

struct CornersHash {
  std::size_t operator()(const glm::uvec3& t) const { return hash_of_three(t.x, t.y, t.z); }
};
// Triangles that are measured already, and near enough.
using Measured = std::unordered_map<glm::uvec3, Known, CornersHash>;

constexpr std::size_t kGrain = 256;

// The ends of the ranges follow from the size alone, and with them every hint.
template <class Body>
void for_ranges(std::size_t size, const Body& body) {
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, size, kGrain),
      [&](const tbb::blocked_range<std::size_t>& part) { body(part.begin(), part.end()); }, tbb::simple_partitioner());
}

class Simplifier {
 public:
  Simplifier(const mesh::Mesh& mesh, const SimplifyOptions& options, Simplification& facts, const Context& context)
      : mesh_(mesh),
        options_(options),
        facts_(facts),
        context_(context),
        original_(mesh.triangles.begin(), mesh.triangles.end()) {
    place_vertices();
    limits_.tolerance = 0;
    limits_.enough = options.max_distance - slack_;
    limits_.refuse = limits_.enough;
    constexpr double kOfVertices = 0.95;  // vertices are less far away than what lies between them
    distance_ = kOfVertices * limits_.enough;
    limits_.floor = 1e-3 * limits_.enough;  // what is so near to the limit is refused, not looked into without end
  }

  // Fails where the context is cancelled.
  Result<Triangles> run() {
    for (const glm::uvec3& t : original_) faces_.push_back({t, {}});
    known_.resize(original_.size());
    known_of_original_.resize(original_.size());
    if (!(limits_.enough > 0)) return original_;
    original_tree_.emplace(positions_, original_);
    for (const double shift : {0.0, 0.5}) {
      if (auto done = round(shift); !done) return tl::unexpected(std::move(done.error()));
    }
    facts_.measured_lower = 0;
    facts_.measured_upper = 0;
    for (const std::vector<Known>* all : {&known_, &known_of_original_}) {
      for (const Known& known : *all) {
        facts_.measured_lower = std::max(facts_.measured_lower, known.lower);
        facts_.measured_upper = std::max(facts_.measured_upper, known.upper);
      }
    }
    if (faces_.size() < original_.size()) facts_.measured_upper += slack_;
    if (facts_.measured_upper > options_.max_distance) {  // no patch is to blame: rounding is
      facts_.measured_lower = facts_.measured_upper = 0;
      return original_;
    }
    Triangles triangles;
    for (const Face& face : faces_) triangles.push_back(face.corners);
    return triangles;
  }

 private:
  // Positions in the space of to_metric. Without a map they are the mesh's own; with one, rounding moves them.
  void place_vertices() {
    if (options_.to_metric == glm::dmat3(1.0)) {
      positions_ = mesh_.positions.span();
      return;
    }
    placed_.resize(mesh_.positions.size());
    double farthest = 0;
    for (std::size_t v = 0; v < placed_.size(); ++v) {
      placed_[v] = options_.to_metric * glm::dvec3(mesh_.positions[v]);
      const glm::vec3 size = glm::abs(placed_[v]);
      farthest = std::max(farthest, static_cast<double>(std::max({size.x, size.y, size.z})));
    }
    positions_ = placed_;
    slack_ = 4 * farthest * 0x1p-24;  // both surfaces move by at most half a last place on each axis
  }

  [[nodiscard]] std::array<glm::dvec3, 3> corners(const glm::uvec3& t) const {
    return {glm::dvec3(positions_[t.x]), glm::dvec3(positions_[t.y]), glm::dvec3(positions_[t.z])};
  }

  [[nodiscard]] Box box_of(const glm::uvec3& t) const {
    Box box;
    for (const glm::dvec3& corner : corners(t)) box.add(corner);
    return box;
  }

  // Whether the triangle is within what was asked; what was found out on the way. `hint` follows along.
  [[nodiscard]] mesh::TriangleBound bound(const glm::uvec3& t, const mesh::TriangleTree& tree,
                                          std::uint32_t hint) const {
    return mesh::bound_distance(corners(t), tree, limits_, 0, hint);
  }
  [[nodiscard]] bool good(const mesh::TriangleBound& bound) const { return bound.upper <= limits_.enough; }

  Result<void> round(double shift) {
    std::vector<Patch> patches = split(shift);
    facts_.patches += patches.size();
    std::vector<char> doubtful(original_.size(), 1);
    std::vector<std::uint32_t> touched;  // patches that changed since the last measurement
    constexpr int kPasses = 5;
    for (int pass = 0;; ++pass) {
      if (auto going_on = context_.check(); !going_on) return going_on;
      ++facts_.passes;
      context_.progress().begin("simplifying", 0);
      tbb::parallel_for(std::size_t{0}, patches.size(), [&](std::size_t p) {
        if (patches[p].pending) simplify(patches[p]);
      });
      if (pass > 0) doubt_near(patches, touched, doubtful);
      context_.progress().begin("measuring the simplified mesh", 0);
      touched = measure_original(patches, doubtful, pass + 1 >= kPasses);
      if (touched.empty()) break;
    }
    faces_.clear();
    known_.clear();
    for (Patch& patch : patches) {
      facts_.patches_kept += patch.changed() ? 0 : 1;
      std::move(patch.after.begin(), patch.after.end(), std::back_inserter(faces_));
      known_.insert(known_.end(), patch.known_after.begin(), patch.known_after.end());
    }
    return {};
  }

  // By the box of the grid that a triangle's centroid is in, in the order of the boxes.
  [[nodiscard]] std::vector<Patch> split(double shift) {
    struct Place {
      std::array<std::int64_t, 3> cell;
      std::uint32_t triangle;
    };
    std::vector<Place> places(faces_.size());
    for_ranges(places.size(), [&](std::size_t first, std::size_t last) {
      for (std::size_t t = first; t < last; ++t) {
        const auto [a, b, c] = corners(faces_[t].corners);
        const glm::i64vec3 cell(glm::floor((a + b + c) / (3 * options_.patch_size) + shift));
        places[t] = {{cell.z, cell.y, cell.x}, static_cast<std::uint32_t>(t)};
      }
    });
    tbb::parallel_sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
      return a.cell != b.cell ? a.cell < b.cell : a.triangle < b.triangle;
    });
    std::vector<Patch> patches;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (i == 0 || places[i].cell != places[i - 1].cell) patches.emplace_back();
      Patch& patch = patches.back();
      Face& face = faces_[places[i].triangle];
      patch.known_before.push_back(known_[places[i].triangle]);
      for (const glm::dvec3& corner : corners(face.corners)) patch.box.add(corner);
      patch.before.push_back(std::move(face));
    }
    for (Patch& patch : patches) {
      patch.after = patch.before;
      patch.known_after = patch.known_before;
    }
    return patches;
  }

  // Makes patch.after of patch.before: every face of it is near enough to the mesh that came in.
  void simplify(Patch& patch) const {
    Measured measured;
    for (std::size_t f = 0; f < patch.before.size(); ++f) measured[patch.before[f].corners] = patch.known_before[f];
    // What takes long to decide is near to the limit: it is refused.
    mesh::DistanceLimits quick = limits_;
    quick.most_parts = 64;
    std::uint32_t hint = 0;
    const auto near_enough = [&](const glm::uvec3& t) {
      if (measured.contains(t)) return true;
      const mesh::TriangleBound found = mesh::bound_distance(corners(t), *original_tree_, quick, 0, hint);
      hint = found.slot;
      if (!good(found) || !has_area(t)) return false;
      measured[t] = {found.lower, found.upper};
      return true;
    };
    // Faces that reach into a held box stay; to the others they are a border.
    std::vector<Face> rest;
    patch.after.clear();
    for (const Face& face : patch.before) {
      const Box box = box_of(face.corners);
      const bool held =
          std::any_of(patch.held.begin(), patch.held.end(), [&](const Box& b) { return box.overlaps(b, 0); });
      (held ? patch.after : rest).push_back(face);
    }
    rest = simplify_patch(positions_, std::move(rest), distance_, near_enough);
    std::move(rest.begin(), rest.end(), std::back_inserter(patch.after));
    patch.known_after.clear();
    for (const Face& face : patch.after) patch.known_after.push_back(measured.at(face.corners));
    patch.pending = false;
  }

  // In double, of the stored positions.
  [[nodiscard]] bool has_area(const glm::uvec3& t) const {
    const glm::dvec3 a(mesh_.positions[t.x]);
    return glm::cross(glm::dvec3(mesh_.positions[t.y]) - a, glm::dvec3(mesh_.positions[t.z]) - a) != glm::dvec3(0);
  }

  // Bounds the distances of those original triangles that are in doubt. Where one is too far away, the patches around
  // are to be simplified again, or kept as they were if this is the `last` pass. Returns those patches.
  std::vector<std::uint32_t> measure_original(std::vector<Patch>& patches, const std::vector<char>& doubtful,
                                              bool last) {
    Triangles all;
    for (const Patch& patch : patches) {
      for (const Face& face : patch.after) all.push_back(face.corners);
    }
    const mesh::TriangleTree tree(positions_, all);
    const std::unordered_set<glm::uvec3, CornersHash> present(all.begin(), all.end());
    std::vector<char> too_far(original_.size(), 0);
    for_ranges(original_.size(), [&](std::size_t first, std::size_t end) {
      std::uint32_t hint = 0;
      for (std::size_t t = first; t < end; ++t) {
        if (doubtful[t] == 0) continue;
        if (present.contains(original_[t])) {
          known_of_original_[t] = {};
          continue;
        }
        const mesh::TriangleBound found = bound(original_[t], tree, hint);
        hint = found.slot;
        known_of_original_[t] = {found.lower, found.upper};
        too_far[t] = good(found) ? 0 : 1;
      }
    });
    std::vector<std::uint32_t> redo;
    const auto do_again = [&](std::uint32_t p, const Box& where) {
      patches[p].held.push_back(where);
      redo.push_back(p);
    };
    for (std::size_t t = 0; t < too_far.size(); ++t) {
      if (too_far[t] == 0) continue;
      // Before the round it was near enough to triangles that reach into this box: they are held.
      Box reach = box_of(original_[t]);
      reach.min -= options_.max_distance;
      reach.max += options_.max_distance;
      for (std::uint32_t p = 0; p < patches.size(); ++p) {
        if (patches[p].changed() && patches[p].box.overlaps(reach, 0)) do_again(p, reach);
      }
    }
    std::sort(redo.begin(), redo.end());
    redo.erase(std::unique(redo.begin(), redo.end()), redo.end());
    for (const std::uint32_t p : redo) {
      patches[p].pending = !last;
      if (last) patches[p].keep();
    }
    return redo;
  }

  // What is near to a patch that changed may have lost what it was near to. By the cells that the patches reach.
  void doubt_near(const std::vector<Patch>& patches, const std::vector<std::uint32_t>& touched,
                  std::vector<char>& doubtful) const {
    constexpr double kManyCells = 4;  // then most of the mesh is near
    if (options_.max_distance > kManyCells * options_.patch_size) {
      std::fill(doubtful.begin(), doubtful.end(), 1);
      return;
    }
    using Cell = std::array<std::int64_t, 3>;
    const auto for_cells = [&](const Box& box, const auto& body) {
      const glm::i64vec3 low(glm::floor(box.min / options_.patch_size));
      const glm::i64vec3 high(glm::floor(box.max / options_.patch_size));
      for (std::int64_t z = low.z; z <= high.z; ++z) {
        for (std::int64_t y = low.y; y <= high.y; ++y) {
          for (std::int64_t x = low.x; x <= high.x; ++x) body(Cell{z, y, x});
        }
      }
    };
    std::vector<Cell> cells;
    for (const std::uint32_t p : touched) {
      Box reach = patches[p].box;
      reach.min -= options_.max_distance;
      reach.max += options_.max_distance;
      for_cells(reach, [&](const Cell& cell) { cells.push_back(cell); });
    }
    std::sort(cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    for_ranges(original_.size(), [&](std::size_t first, std::size_t last) {
      for (std::size_t t = first; t < last; ++t) {
        doubtful[t] = 0;
        for_cells(box_of(original_[t]), [&](const Cell& cell) {
          if (std::binary_search(cells.begin(), cells.end(), cell)) doubtful[t] = 1;
        });
      }
    });
  }

  const mesh::Mesh& mesh_;
  const SimplifyOptions& options_;
  Simplification& facts_;
  const Context& context_;
  Triangles original_;
  std::vector<glm::vec3> placed_;
  std::span<const glm::vec3> positions_;
  double slack_ = 0;
  mesh::DistanceLimits limits_;
  double distance_ = 0;  // that vertices may have
  std::optional<mesh::TriangleTree> original_tree_;
  std::vector<Face> faces_;               // of the current mesh
  std::vector<Known> known_;              // of their distance to the mesh that came in
  std::vector<Known> known_of_original_;  // of the distance of that mesh's triangles to the current mesh
};

// Vertices that no triangle uses any more are left out; the others keep their order. Edge keys go: they are of meshes
// as they were extracted.
void set_triangles(mesh::Mesh& mesh, const Triangles& triangles) {
  constexpr std::uint32_t kUnused = ~0U;
  std::vector<std::uint32_t> number(mesh.positions.size(), kUnused);
  for (const glm::uvec3& t : triangles) number[t.x] = number[t.y] = number[t.z] = 0;
  std::vector<std::uint32_t> used;
  for (std::uint32_t v = 0; v < number.size(); ++v) {
    if (number[v] == kUnused) continue;
    number[v] = static_cast<std::uint32_t>(used.size());
    used.push_back(v);
  }
  mesh.edges = {};
  Buffer<glm::uvec3> renumbered(triangles.size());
  std::transform(triangles.begin(), triangles.end(), renumbered.begin(),
                 [&](const glm::uvec3& t) { return glm::uvec3(number[t.x], number[t.y], number[t.z]); });
  gather_vertices(mesh, used);
  mesh.triangles = std::move(renumbered);
}

// What a Simplifier takes at most at a time: all triangles as faces in patches, before and after, with what is known of
// them, two trees, and a table of those that are there; places of vertices, and their numbers.
std::uint64_t working_bytes(const mesh::Mesh& mesh) {
  constexpr std::uint64_t kTree = 9 * sizeof(glm::vec3) + 8;
  constexpr std::uint64_t kTable = 48;  // an entry of a hash table, with its node and its place
  constexpr std::uint64_t kTriangle =
      3 * sizeof(glm::uvec3) + 3 * sizeof(Face) + 4 * sizeof(Known) + 2 * kTree + kTable;
  constexpr std::uint64_t kVertex = 2 * sizeof(glm::vec3) + 3 * sizeof(std::uint32_t);
  return mesh.triangles.size() * kTriangle + mesh.positions.size() * (kVertex + vertex_bytes(mesh));
}

Result<SimplifiedMesh> simplified(mesh::Mesh mesh, const SimplifyOptions& options, const Context& context) {
  const Stopwatch watch;
  SimplifiedMesh result;
  Simplification& facts = result.facts;
  facts.asked = options.max_distance;
  facts.triangles_before = mesh.triangles.size();
  if (!mesh.triangles.empty()) {
    const auto triangles = Simplifier(mesh, options, facts, context).run();
    if (!triangles) return tl::unexpected(triangles.error());
    if (triangles->size() < mesh.triangles.size()) set_triangles(mesh, *triangles);
  }
  facts.triangles_after = mesh.triangles.size();
  facts.time = watch.elapsed();
  mesh.memory.shrink(mesh.positions.size() * vertex_bytes(mesh) + mesh.triangles.size_bytes());
  result.mesh = std::move(mesh);
  return result;
}

}  // namespace

Result<SimplifiedMesh> simplify_within(mesh::Mesh mesh, const SimplifyOptions& options, const Context& context) {
  const std::string what = mesh.name + ": the triangles that are simplified";
  const auto memory = context.reserve(working_bytes(mesh), what);
  if (!memory) return tl::unexpected(memory.error());
  try {
    return simplified(std::move(mesh), options, context);
  } catch (const std::bad_alloc&) {
    return fail(ErrorKind::input, what + " need more memory than there is", Remedy::extract_part);
  }
}

}  // namespace isoextract::edit
