// Grid tools with OpenVDB: level sets from particles, filtered and rebuilt level sets, and VDB files
// (grid_tools_plugin.h).
//
// Uses openvdb::tools::ParticlesToLevelSet for the union of spheres, and openvdb_smooth_spheres.hpp for the smooth
// surface.
#include <cmath>
#include <limits>
#include <memory>
#include <ostream>
#include <span>
#include <unordered_map>
#include <unordered_set>

#include <openvdb/points/PointAttribute.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetFilter.h>
#include <openvdb/tools/LevelSetRebuild.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/ParticlesToLevelSet.h>
#include <openvdb/tree/LeafManager.h>

#include <grid_tools_plugin.h>
#include "openvdb_file.hpp"
#include "openvdb_input.hpp"
#include "openvdb_parts.hpp"
#include "openvdb_smooth_spheres.hpp"

namespace {

using namespace isoextract_openvdb;  // NOLINT(google-build-using-namespace): all of this file is of it
// Output grids.

void give(const FloatGrid& grid, std::int32_t kind, Reserved& memory, isoextract_grid_output* output) {
  auto store = std::make_unique<SparseStore>();
  copy_tree_to_store<float>(grid.tree(), ISOEXTRACT_F32, memory, *store, [](float value) { return value; });
  output->samples = store->samples;
  put_transform(grid.transform(), output->index_to_world);
  output->kind = kind;
  output->owner = store.release();
  memory.keep();
}

// Particles.

// The particles that are large enough, in the interface that OpenVDB requires.
class Particles {
 public:
  using PosType = openvdb::Vec3R;
  using value_type = PosType;

  Particles(const isoextract_sphere_job& job, Reserved& memory) : job_(job) {
    memory.take(job.count * sizeof(std::uint64_t));
    kept_.reserve(job.count);
    for (std::uint64_t i = 0; i < job.count; ++i) {
      const double radius = radius_of(i);
      if (!(std::isfinite(radius) && radius >= 0)) {
        throw PluginError("expected radii of 0 or more, found " + std::to_string(radius));
      }
      const openvdb::Vec3d at = position_of(i);
      for (int axis = 0; axis < 3; ++axis) {
        if (!(std::abs(at[axis]) + radius < (kMostIndex - 64) * job.voxel)) {
          throw PluginError("expected particles within 2^29 voxels of the origin, found one at " + at.str());
        }
      }
      if (radius >= job.least_radius * job.voxel) kept_.push_back(i);
    }
  }

  [[nodiscard]] std::size_t size() const { return kept_.size(); }
  // The names are OpenVDB's. NOLINTBEGIN(readability-identifier-naming)
  void getPos(std::size_t n, openvdb::Vec3R& at) const { at = position_of(kept_[n]); }
  void getPosRad(std::size_t n, openvdb::Vec3R& at, openvdb::Real& radius) const {
    at = position_of(kept_[n]);
    radius = radius_of(kept_[n]);
  }
  // NOLINTEND(readability-identifier-naming)
  [[nodiscard]] std::vector<float> radii() const {
    std::vector<float> all(size());
    std::ranges::transform(kept_, all.begin(), [&](std::uint64_t i) { return static_cast<float>(radius_of(i)); });
    return all;
  }

  [[nodiscard]] std::uint64_t left_out() const { return job_.count - kept_.size(); }

 private:
  [[nodiscard]] double radius_of(std::uint64_t i) const {
    return job_.radii == nullptr ? job_.radius : static_cast<double>(job_.radii[i]);
  }
  [[nodiscard]] openvdb::Vec3d position_of(std::uint64_t i) const {
    return {job_.positions[3 * i], job_.positions[3 * i + 1], job_.positions[3 * i + 2]};
  }

  const isoextract_sphere_job& job_;
  std::vector<std::uint64_t> kept_;
};

// Reserves memory of hash tables as they grow.
class TableMemory {
 public:
  explicit TableMemory(const isoextract_plugin_host& host) : memory_(host) {}

  void add_entry() {
    if (entries_++ % kStep == 0) memory_.take(kStep * kEntryBytes);
  }

 private:
  static constexpr std::uint64_t kStep = 1024;
  static constexpr std::uint64_t kEntryBytes = 64;  // includes the allocator's overhead, and buckets during rehashing

  Reserved memory_;
  std::uint64_t entries_ = 0;
};

// Counts the leaves that a grid will have, each once, up to kMost.
class LeafCount {
 public:
  explicit LeafCount(const isoextract_plugin_host& host) : memory_(host) {}

  // Adds the leaves of a box of leaf coordinates.
  void add(const openvdb::CoordBBox& box) {
    for (auto at = box.begin(); at && !is_full(); ++at) {
      if (touched_.insert(*at).second) memory_.add_entry();
    }
  }
  [[nodiscard]] bool is_full() const { return touched_.size() > kMost; }
  [[nodiscard]] std::uint64_t count() const {
    return is_full() ? std::numeric_limits<std::uint32_t>::max() : touched_.size();
  }

 private:
  static constexpr std::size_t kMost = std::size_t{1} << 24;

  TableMemory memory_;
  std::unordered_set<openvdb::Coord> touched_;
};

// Returns an upper bound for the leaves that the narrow band and its construction touch. Particles in one leaf count
// once, with the largest reach among them.
std::uint64_t max_touched_leaves(const Particles& particles, const isoextract_sphere_job& job,
                                 const isoextract_plugin_host& host) {
  TableMemory memory(host);
  std::unordered_map<openvdb::Coord, int> reach;  // of a leaf's particles, in leaves
  for (std::size_t i = 0; i < particles.size(); ++i) {
    openvdb::Vec3R at;
    double radius = 0;
    particles.getPosRad(i, at, radius);
    if (job.method == ISOEXTRACT_SMOOTH_SPHERES) radius = smoothing_reach(radius, job.search_radius);
    const double leaves = std::ceil((radius / job.voxel + job.half_band + 2) / 8);
    if (leaves > 1e4) return std::numeric_limits<std::uint32_t>::max();
    const openvdb::Vec3d place = at / (8 * job.voxel);
    const auto [known, is_new] = reach.try_emplace(openvdb::Coord::floor(place), static_cast<int>(leaves));
    if (is_new) memory.add_entry();
    known->second = std::max(known->second, static_cast<int>(leaves));
  }
  LeafCount touched(host);
  for (const auto& [leaf, leaves] : reach) touched.add({leaf.offsetBy(-leaves), leaf.offsetBy(leaves)});
  return touched.count();
}

// The factor 2: each thread builds its own grid, and these grids overlap where their particles do.
std::uint64_t max_grid_bytes(const Particles& particles, const isoextract_sphere_job& job,
                             const isoextract_plugin_host& host) {
  return 2 * max_touched_leaves(particles, job, host) * kLeafBytes;
}

FloatGrid::Ptr united_spheres(const Particles& particles, const isoextract_sphere_job& job,
                              HostInterrupter& interrupter) {
  FloatGrid::Ptr grid = openvdb::createLevelSet<FloatGrid>(job.voxel, job.half_band);
  openvdb::tools::ParticlesToLevelSet<FloatGrid> raster(*grid, &interrupter);
  raster.setRmin(0);
  raster.setRmax(std::numeric_limits<double>::max());
  raster.rasterizeSpheres(particles);
  interrupter.check();
  raster.finalize(true);
  return grid;
}

FloatGrid::Ptr smooth_spheres(const Particles& particles, const isoextract_sphere_job& job,
                              HostInterrupter& interrupter, Reserved& memory) {
  namespace points = openvdb::points;
  constexpr std::uint64_t kBytesPerPoint = 64;  // index, position and radius, and intermediate lists
  memory.take(particles.size() * kBytesPerPoint);
  const auto transform = openvdb::math::Transform::createLinearTransform(job.voxel);
  const auto index = openvdb::tools::createPointIndexGrid<openvdb::tools::PointIndexGrid>(particles, *transform);
  const auto grid =
      points::createPointDataGrid<points::NullCodec, points::PointDataGrid>(*index, particles, *transform);
  const std::string radius = "pscale";
  points::appendAttribute<float>(grid->tree(), radius);
  const std::vector<float> radii = particles.radii();
  points::populateAttribute(grid->tree(), index->tree(), radius, points::PointAttributeVector<float>(radii));
  interrupter.check();
  auto surface = smooth_surface(*grid, radius, job.search_radius, job.half_band, interrupter);
  return surface;
}

void check_half_band(double half_band) {
  if (!(half_band >= 2 && half_band <= 1000)) {
    throw PluginError("expected a narrow band of 2 to 1000 voxels on either side of the surface");
  }
}

void check_spheres(const isoextract_sphere_job& job) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  if (!positive(job.voxel)) throw PluginError("expected a voxel size above 0");
  check_half_band(job.half_band);
  if (job.method == ISOEXTRACT_SMOOTH_SPHERES && !positive(job.search_radius)) {
    throw PluginError("expected a search radius above 0");
  }
}

int spheres(const isoextract_sphere_job* job, const isoextract_plugin_host* host, isoextract_grid_output* output) {
  return catch_exceptions([&] {
    *output = {};
    check_spheres(*job);
    Reserved for_work(*host);
    Reserved for_samples(*host);
    HostInterrupter interrupter(*host);
    const Particles particles(*job, for_work);
    output->left_out = particles.left_out();
    FloatGrid::Ptr grid = openvdb::createLevelSet<FloatGrid>(job->voxel, job->half_band);
    if (particles.size() > 0) {
      Reserved for_grid(*host);
      for_grid.take(max_grid_bytes(particles, *job, *host));
      grid = job->method == ISOEXTRACT_SMOOTH_SPHERES ? smooth_spheres(particles, *job, interrupter, for_work)
                                                      : united_spheres(particles, *job, interrupter);
      for_work.take(grid->memUsage());
    }
    if (job->kind == ISOEXTRACT_DENSITY) {
      openvdb::tools::sdfToFogVolume(*grid);
    } else {
      openvdb::tools::pruneLevelSet(grid->tree());
    }
    give(*grid, job->kind, for_samples, output);
  });
}

int sphere_bytes(const isoextract_sphere_job* job, const isoextract_plugin_host* host, std::uint64_t* bytes) {
  return catch_exceptions([&] {
    check_spheres(*job);
    Reserved for_work(*host);
    *bytes = max_grid_bytes(Particles(*job, for_work), *job, *host);
  });
}

// Filters.

int filter(const isoextract_filter_job* job, const isoextract_plugin_host* host, isoextract_grid_output* output) {
  return catch_exceptions([&] {
    *output = {};
    Reserved for_work(*host);
    Reserved for_samples(*host);
    HostInterrupter interrupter(*host);
    if (job->grid.kind != ISOEXTRACT_LEVEL_SET) throw PluginError("expected a level set, found a density");
    FloatGrid::Ptr grid = GridBuilder(job->grid, for_work).build();
    if (!grid->hasUniformVoxels()) throw PluginError("expected cubic voxels");
    if (!(grid->background() > 0)) {
      throw PluginError("expected a level set that is positive far outside, found " +
                        std::to_string(grid->background()));
    }
    // Two buffers besides the grid's own, and new leaves where the band moves.
    for_work.take(3 * grid->memUsage());
    openvdb::tools::LevelSetFilter<FloatGrid> work(*grid, &interrupter);
    const auto width = static_cast<int>(std::clamp<std::uint32_t>(job->width, 1, 64));
    for (std::uint32_t i = 0; i < job->iterations; ++i) {
      switch (job->filter) {
        case ISOEXTRACT_GAUSSIAN: work.gaussian(width); break;
        case ISOEXTRACT_MEDIAN: work.median(width); break;
        case ISOEXTRACT_MEAN: work.mean(width); break;
        default: throw PluginError("expected a known filter, found " + std::to_string(job->filter));
      }
      interrupter.check();
    }
    give(*grid, ISOEXTRACT_LEVEL_SET, for_samples, output);
  });
}

// Rebuilding.

// The axes of a rebuild, without rotation and translation: distances do not depend on them, and OpenVDB's mesh has
// float positions, which would lose digits far from the origin.
struct RebuildAxes {
  openvdb::Coord start;  // of the input, at the local origin
  openvdb::Vec3d edges;  // of an input voxel, in world units
  double voxel = 0;      // edge of an output voxel
  openvdb::Vec3d shift;  // local position of output sample (0, 0, 0)

  // Convert an index of one grid to a fractional index of the other.
  [[nodiscard]] openvdb::Vec3d output_index(const openvdb::Coord& input) const {
    return (edges * (input - start).asVec3d() - shift) / voxel;
  }
  [[nodiscard]] openvdb::Vec3d input_index(const openvdb::Coord& output) const {
    return (voxel * output.asVec3d() + shift) / edges + start.asVec3d();
  }
};

RebuildAxes axes_of(const isoextract_rebuild_job& job, const FloatGrid& grid) {
  constexpr double kRounding = 1e-5;
  const openvdb::Mat4d matrix = grid.transform().baseMap()->getAffineMap()->getMat4();
  RebuildAxes axes;
  const openvdb::CoordBBox active = grid.evalActiveVoxelBoundingBox();
  if (!active.empty()) axes.start = active.min();
  std::array<openvdb::Vec3d, 3> along;
  for (int axis = 0; axis < 3; ++axis) {
    along.at(axis) = {matrix[axis][0], matrix[axis][1], matrix[axis][2]};
    axes.edges[axis] = along.at(axis).length();
    const double voxel = axes.edges[axis] * job.step[axis];
    if (!(std::isfinite(voxel) && voxel > 0)) throw PluginError("expected a voxel size above 0");
    if (axis == 0) axes.voxel = voxel;
    if (std::abs(voxel - axes.voxel) > kRounding * axes.voxel) throw PluginError("expected cubic voxels");
    axes.shift[axis] = axes.edges[axis] * (job.first[axis] - axes.start[axis]);
  }
  for (int axis = 0; axis < 3; ++axis) {
    const int next = (axis + 1) % 3;
    if (std::abs(along.at(axis).dot(along.at(next))) > kRounding * axes.edges[axis] * axes.edges[next]) {
      throw PluginError("expected perpendicular axes");
    }
  }
  return axes;
}

// Reserves the memory of the mesh and of the new band, from the voxels at the surface.
void reserve_rebuild(const FloatGrid& grid, const RebuildAxes& axes, double half_band,
                     const isoextract_plugin_host& host, Reserved& memory) {
  constexpr std::uint64_t kBytesPerVoxel = 128;  // of the mesh, at the surface
  LeafCount touched(host);
  std::uint64_t at_surface = 0;
  openvdb::CoordBBox last;
  auto neighbors = grid.getConstAccessor();
  const openvdb::Vec3d margin(half_band + 1);
  for (auto voxel = grid.cbeginValueOn(); voxel; ++voxel) {
    const openvdb::Coord at = voxel.getCoord();
    const bool inside = *voxel < 0;
    const auto differs = [&](int x, int y, int z) { return (neighbors.getValue(at.offsetBy(x, y, z)) < 0) != inside; };
    if (!differs(1, 0, 0) && !differs(0, 1, 0) && !differs(0, 0, 1) && !differs(-1, 0, 0) && !differs(0, -1, 0) &&
        !differs(0, 0, -1)) {
      continue;
    }
    ++at_surface;
    const openvdb::Vec3d low = axes.output_index(at.offsetBy(-1)) - margin;
    const openvdb::Vec3d high = axes.output_index(at.offsetBy(1)) + margin;
    for (int axis = 0; axis < 3; ++axis) {
      if (!(low[axis] > -kMostIndex && high[axis] < kMostIndex)) {
        throw PluginError("expected output indices within 2^29");
      }
    }
    const openvdb::CoordBBox box(openvdb::Coord::floor(low / 8), openvdb::Coord::floor(high / 8));
    if (box != last) touched.add(box);
    last = box;
  }
  // Two trees for the mesh (signs, point indices); four for the band (distances and nearest polygons, per thread and
  // merged).
  memory.take(at_surface * kBytesPerVoxel + 2 * grid.constTree().leafCount() * kLeafBytes +
              4 * touched.count() * kLeafBytes);
}

// Sets the voxels near the surface to the trilinear interpolant of the input, so that both grids have one surface.
// OpenVDB's mesh has its vertices inside convex regions, which shrinks them. Keeps the rebuilt distances where the
// input has its background, or where its values are no distances.
void keep_surface(const FloatGrid& input, const RebuildAxes& axes, FloatGrid& rebuilt) {
  using openvdb::tools::BoxSampler;
  const float input_band = 0.999F * input.background();
  const float band = rebuilt.background();
  const double most_moved = 0.25 * std::min({axes.edges[0], axes.edges[1], axes.edges[2]});
  openvdb::tree::LeafManager<FloatTree> leaves(rebuilt.tree());
  leaves.foreach ([&](Leaf& leaf, std::size_t /*number*/) {
    auto samples = input.getConstAccessor();
    for (auto voxel = leaf.beginValueOn(); voxel; ++voxel) {
      const openvdb::Vec3d at = axes.input_index(voxel.getCoord());
      const openvdb::Coord low = openvdb::Coord::floor(at);
      float corners[2][2][2];  // NOLINT(modernize-avoid-c-arrays): OpenVDB's parameter
      BoxSampler::getValues(corners, samples, low);
      const bool is_cut =
          std::ranges::any_of(std::span(&corners[0][0][0], 8), [&](float c) { return !(std::abs(c) < input_band); });
      if (is_cut) continue;
      const float value = BoxSampler::trilinearInterpolation(corners, at - low.asVec3d());
      if (std::abs(value) < band && std::abs(value - *voxel) <= most_moved) voxel.setValue(value);
    }
  });
}

int rebuild(const isoextract_rebuild_job* job, const isoextract_plugin_host* host, isoextract_grid_output* output) {
  return catch_exceptions([&] {
    *output = {};
    Reserved for_work(*host);
    Reserved for_samples(*host);
    HostInterrupter interrupter(*host);
    if (job->grid.kind != ISOEXTRACT_LEVEL_SET) throw PluginError("expected a level set, found a density");
    check_half_band(job->half_band);
    FloatGrid::Ptr grid = GridBuilder(job->grid, for_work).build();
    const RebuildAxes axes = axes_of(*job, *grid);
    reserve_rebuild(*grid, axes, job->half_band, *host, for_work);
    openvdb::math::Transform::Ptr from = openvdb::math::Transform::createLinearTransform();
    from->preScale(axes.edges);
    from->preTranslate(-axes.start.asVec3d());
    grid->setTransform(from);
    openvdb::math::Transform::Ptr to = openvdb::math::Transform::createLinearTransform(axes.voxel);
    to->postTranslate(axes.shift);
    const auto band = static_cast<float>(job->half_band);
    auto rebuilt = openvdb::tools::levelSetRebuild(*grid, 0.0F, band, band, to.get(),
                                                   static_cast<openvdb::util::NullInterrupter*>(&interrupter));
    interrupter.check();
    keep_surface(*grid, axes, *rebuilt);
    openvdb::tools::pruneLevelSet(rebuilt->tree());
    give(*rebuilt, ISOEXTRACT_LEVEL_SET, for_samples, output);
  });
}

void free_output(isoextract_grid_output* output) { delete static_cast<SparseStore*>(output->owner); }

// Files.

int write_vdb(const isoextract_vdb_job* job, const isoextract_plugin_host* host) {
  return catch_exceptions([&] {
    Reserved memory(*host);
    std::vector<FloatGrid::Ptr> grids;
    for (std::uint64_t g = 0; g < job->count; ++g) {
      grids.push_back(GridBuilder(job->grids[g].grid, memory).build());
      grids.back()->setName(job->grids[g].name);
      grids.back()->setSaveFloatAsHalf(job->is_half != 0);
    }
    HostStream buffer(*job, content_name(grids, *job));
    std::ostream stream(&buffer);
    stream.exceptions(std::ios_base::badbit);
    try {
      HostArchive().put(stream, {grids.begin(), grids.end()}, job->overwrite != nullptr);
    } catch (const std::ios_base::failure&) {
      if (!buffer.failed()) throw;
    }
    if (buffer.failed()) throw PluginError("writing the file failed");
  });
}

const char* error_text() { return problem.c_str(); }

constexpr isoextract_grid_tools_plugin_v4 kPlugin{ISOEXTRACT_GRID_TOOLS_PLUGIN_VERSION,
                                                  "openvdb",
                                                  spheres,
                                                  filter,
                                                  rebuild,
                                                  free_output,
                                                  sphere_bytes,
                                                  write_vdb,
                                                  error_text};

}  // namespace

const isoextract_grid_tools_plugin_v4* isoextract_grid_tools_plugin() { return &kPlugin; }
