// Grid tools with OpenVDB: level sets from particles, level set filters, and VDB files (grid_tools_plugin.h).
//
// Uses openvdb::tools::ParticlesToLevelSet for the union of spheres, and openvdb_smooth_spheres.hpp for the smooth
// surface.
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <ostream>
#include <span>
#include <unordered_map>
#include <unordered_set>

#include <openvdb/points/PointAttribute.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/tools/LevelSetFilter.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/ParticlesToLevelSet.h>

#include <grid_tools_plugin.h>
#include "openvdb_file.hpp"
#include "openvdb_parts.hpp"
#include "openvdb_smooth_spheres.hpp"

namespace {

using namespace isoextract_openvdb;  // NOLINT(google-build-using-namespace): all of this file is of it
using openvdb::FloatGrid;
using openvdb::FloatTree;
using Leaf = FloatTree::LeafNodeType;

constexpr double kMostIndex = 1 << 29;  // limit of voxel indices; keeps arithmetic within an int

// Grids that come in.

template <class F>
void visit_samples(std::int32_t type, const void* data, F&& use) {
  const auto as = [&]<class T>(std::type_identity<T>) { use(static_cast<const T*>(data)); };
  switch (type) {
    case ISOEXTRACT_U8: return as(std::type_identity<std::uint8_t>{});
    case ISOEXTRACT_I8: return as(std::type_identity<std::int8_t>{});
    case ISOEXTRACT_U16: return as(std::type_identity<std::uint16_t>{});
    case ISOEXTRACT_I16: return as(std::type_identity<std::int16_t>{});
    case ISOEXTRACT_U32: return as(std::type_identity<std::uint32_t>{});
    case ISOEXTRACT_I32: return as(std::type_identity<std::int32_t>{});
    case ISOEXTRACT_F16: return as(std::type_identity<openvdb::math::half>{});
    case ISOEXTRACT_F32: return as(std::type_identity<float>{});
    case ISOEXTRACT_F64: return as(std::type_identity<double>{});
    default: throw PluginError("expected samples of a known type, found type " + std::to_string(type));
  }
}

bool same_bits(float a, float b) { return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b); }

class GridBuilder {
 public:
  GridBuilder(const isoextract_grid_input& input, Reserved& memory) : input_(input), memory_(memory) {}

  FloatGrid::Ptr build() {
    if (input_.sparse != nullptr) {
      from_sparse(*input_.sparse);
    } else {
      from_box();
    }
    const bool is_level_set = input_.kind == ISOEXTRACT_LEVEL_SET;
    grid_->setGridClass(is_level_set ? openvdb::GRID_LEVEL_SET : openvdb::GRID_FOG_VOLUME);
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) matrix[column][row] = input_.index_to_world[4 * row + column];
    }
    grid_->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    return grid_;
  }

 private:
  [[nodiscard]] float value_of(double stored) const {
    const bool as_it_is = input_.slope == 1 && input_.intercept == 0;
    return static_cast<float>(as_it_is ? stored : input_.slope * stored + input_.intercept);
  }

  // Floats are unchanged bit by bit.
  template <class T>
  [[nodiscard]] float sample(T stored) const {
    if constexpr (std::is_same_v<T, float>) {
      if (input_.slope == 1 && input_.intercept == 0) return stored;
    }
    return value_of(static_cast<double>(stored));
  }

  // Returns whether a voxel is active: the background can restore all other values.
  [[nodiscard]] bool is_active(float value) const {
    const float background = grid_->background();
    if (input_.kind == ISOEXTRACT_LEVEL_SET && same_bits(value, -background)) return false;
    return !same_bits(value, background);
  }

  void from_sparse(const isoextract_sparse_samples& samples) {
    grid_ = FloatGrid::create(value_of(samples.background));
    memory_.take(samples.block_count * kLeafBytes + (std::uint64_t{1} << 20));
    reserve_nodes_above(samples);
    for (std::size_t i = 0; i < samples.tile_count; ++i) add_tile(samples.tiles[i]);
    for (std::size_t i = 0; i < samples.block_count; ++i) {
      const isoextract_sparse_block& block = samples.blocks[i];
      Leaf& leaf = *grid_->tree().touchLeaf({block.origin[0], block.origin[1], block.origin[2]});
      visit_samples(samples.sample_type, block.values, [&](const auto* values) {
        for (openvdb::Index n = 0; n < kLeafValues; ++n) put(leaf, n, sample(values[n]));
      });
    }
  }

  // Scattered bricks can each have their own nodes, which are far larger than a brick.
  void reserve_nodes_above(const isoextract_sparse_samples& samples) {
    using Upper = FloatTree::RootNodeType::ChildNodeType;
    using Lower = Upper::ChildNodeType;
    memory_.take((samples.block_count + samples.tile_count) * sizeof(openvdb::Coord));
    std::vector<openvdb::Coord> nodes;
    nodes.reserve(samples.block_count + samples.tile_count);
    const auto add = [&](const std::int32_t* origin) { nodes.emplace_back(origin[0], origin[1], origin[2]); };
    const auto distinct = [&](openvdb::Index side) {
      for (openvdb::Coord& node : nodes) node &= ~(static_cast<std::int32_t>(side) - 1);
      nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());  // most duplicates are consecutive
      std::ranges::sort(nodes, [](const openvdb::Coord& a, const openvdb::Coord& b) { return a < b; });
      nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
      return static_cast<std::uint64_t>(nodes.size());
    };
    const std::span tiles(samples.tiles, samples.tile_count);
    for (const isoextract_sparse_block& block : std::span(samples.blocks, samples.block_count)) add(block.origin);
    for (const isoextract_sparse_tile& tile : tiles) {
      if (tile.size < static_cast<int>(Lower::DIM)) add(tile.origin);
    }
    const std::uint64_t lower = distinct(Lower::DIM);
    for (const isoextract_sparse_tile& tile : tiles) {
      if (tile.size >= static_cast<int>(Lower::DIM) && tile.size < static_cast<int>(Upper::DIM)) add(tile.origin);
    }
    memory_.take(lower * sizeof(Lower) + distinct(Upper::DIM) * sizeof(Upper));
  }

  void put(Leaf& leaf, openvdb::Index n, float value) const {
    leaf.setValueOnly(n, value);
    leaf.setActiveState(n, is_active(value));
  }

  // Fills the tile with cubes of the tree's node sizes.
  void add_tile(const isoextract_sparse_tile& tile) {
    const float value = value_of(tile.value);
    openvdb::Index level = 1;
    int size = 8;
    if (tile.size >= 4096) {
      level = 3;
      size = 4096;
    } else if (tile.size >= 128) {
      level = 2;
      size = 128;
    }
    for (int x = 0; x < tile.size; x += size) {
      for (int y = 0; y < tile.size; y += size) {
        for (int z = 0; z < tile.size; z += size) {
          grid_->tree().addTile(level, {tile.origin[0] + x, tile.origin[1] + y, tile.origin[2] + z}, value,
                                is_active(value));
        }
      }
    }
  }

  void from_box() {
    std::array<int, 3> dims{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (input_.dims[axis] == 0 || input_.dims[axis] >= static_cast<std::uint64_t>(kMostIndex)) {
        throw PluginError("expected fewer than 2^29 samples along each axis");
      }
      dims[axis] = static_cast<int>(input_.dims[axis]);
    }
    std::uint64_t leaves = 1;
    for (const int dim : dims) leaves *= static_cast<std::uint64_t>((dim + 7) / 8);
    memory_.take(leaves * kLeafBytes);
    visit_samples(input_.sample_type, input_.data, [&](const auto* data) {
      const std::size_t count = input_.dims[0] * input_.dims[1] * input_.dims[2];
      grid_ = FloatGrid::create(outside(data, count));
      for (int x = 0; x < dims[0]; x += 8) {
        for (int y = 0; y < dims[1]; y += 8) {
          for (int z = 0; z < dims[2]; z += 8) put_box(data, dims, {x, y, z});
        }
      }
    });
  }

  // Returns the least value of a density, the greatest of a level set: outside for every iso value.
  template <class T>
  [[nodiscard]] float outside(const T* data, std::size_t count) const {
    const bool greatest = input_.kind == ISOEXTRACT_LEVEL_SET;
    std::optional<float> found;
    for (std::size_t i = 0; i < count; ++i) {
      const float value = sample(data[i]);
      if (std::isfinite(value) && (!found || (greatest ? value > *found : value < *found))) found = value;
    }
    return found.value_or(0.0F);
  }

  template <class T>
  void put_box(const T* data, const std::array<int, 3>& dims, const openvdb::Coord& origin) {
    Leaf* leaf = nullptr;  // null if all values are the background
    for (openvdb::Index n = 0; n < kLeafValues; ++n) {
      const openvdb::Coord at = origin + Leaf::offsetToLocalCoord(n);
      if (at.x() >= dims[0] || at.y() >= dims[1] || at.z() >= dims[2]) continue;
      const auto row = static_cast<std::size_t>(at.y()) + input_.dims[1] * static_cast<std::size_t>(at.z());
      const float value = sample(data[static_cast<std::size_t>(at.x()) + input_.dims[0] * row]);
      if (leaf == nullptr && same_bits(value, grid_->background())) continue;
      if (leaf == nullptr) leaf = grid_->tree().touchLeaf(origin);
      put(*leaf, n, value);
    }
  }

  const isoextract_grid_input& input_;
  Reserved& memory_;
  FloatGrid::Ptr grid_;
};

// Grids that go out.

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

// Returns an upper bound for the leaves that the narrow band and its construction touch. Particles in one leaf count
// once, with the largest reach among them. Stops counting at `kMost`.
std::uint64_t max_touched_leaves(const Particles& particles, const isoextract_sphere_job& job,
                                 const isoextract_plugin_host& host) {
  constexpr std::size_t kMost = std::size_t{1} << 24;
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
  std::unordered_set<openvdb::Coord> touched;
  for (const auto& [leaf, leaves] : reach) {
    for (auto at = openvdb::CoordBBox(leaf.offsetBy(-leaves), leaf.offsetBy(leaves)).begin(); at; ++at) {
      if (touched.insert(*at).second) memory.add_entry();
      if (touched.size() > kMost) return std::numeric_limits<std::uint32_t>::max();
    }
  }
  return touched.size();
}

// Each thread has its own grid; they overlap where their particles do.
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

void check_spheres(const isoextract_sphere_job& job) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  if (!positive(job.voxel)) throw PluginError("expected a voxel size above 0");
  if (!(job.half_band >= 2 && job.half_band <= 1000)) {
    throw PluginError("expected a narrow band of 2 to 1000 voxels on either side of the surface");
  }
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
    // Two buffers besides the grid's own, and new leaves of the moving band.
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

constexpr isoextract_grid_tools_plugin_v4 kPlugin{
    ISOEXTRACT_GRID_TOOLS_PLUGIN_VERSION, "openvdb", spheres, filter, free_output, sphere_bytes, write_vdb, error_text};

}  // namespace

const isoextract_grid_tools_plugin_v4* isoextract_grid_tools_plugin() { return &kPlugin; }
