// OpenVDB grids that the built-in reader does not read: bool, mask and int64 grids; vector grids, by component or
// length; and grids in a frustum, resampled.
//
// A vector grid is listed as four grids: NAME[x], NAME[y], NAME[z] and NAME[length]. Masks and bools become 1 and 0.
// int64 becomes double, which is exact up to 2^53.
//
// A frustum is resampled by trilinear interpolation to a cubic grid aligned with the world's axes. The spacing is the
// shortest edge of the voxel at the frustum's center; one sample is at the world's origin.
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>

#include <openvdb/io/File.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tree/LeafManager.h>

#include <volume_plugin.h>
#include "openvdb_parts.hpp"

namespace {

using namespace isoextract_openvdb;  // NOLINT(google-build-using-namespace): all of this file is of it

constexpr std::int32_t kNotScalar = ISOEXTRACT_NOT_SCALAR;
constexpr std::int32_t kFloat = ISOEXTRACT_F32;
constexpr std::int32_t kDouble = ISOEXTRACT_F64;

enum class Part { all, x, y, z, length };
constexpr std::array kVectorParts{std::pair{Part::x, "[x]"}, std::pair{Part::y, "[y]"}, std::pair{Part::z, "[z]"},
                                  std::pair{Part::length, "[length]"}};

// Calls use(std::type_identity<Grid>{}, sample type of a scalar) with the grid's type; returns false for unsupported
// ones.
template <class F>
bool visit_grid_type(const openvdb::GridBase& grid, F&& use) {
  const auto is = [&]<class Grid>(std::type_identity<Grid> type, std::int32_t sample_type) {
    return grid.isType<Grid>() && (use(type, sample_type), true);
  };
  return is(std::type_identity<openvdb::FloatGrid>{}, ISOEXTRACT_F32) ||
         is(std::type_identity<openvdb::DoubleGrid>{}, ISOEXTRACT_F64) ||
         is(std::type_identity<openvdb::Int32Grid>{}, ISOEXTRACT_I32) ||
         is(std::type_identity<openvdb::Int64Grid>{}, ISOEXTRACT_F64) ||
         is(std::type_identity<openvdb::BoolGrid>{}, ISOEXTRACT_U8) ||
         is(std::type_identity<openvdb::MaskGrid>{}, ISOEXTRACT_U8) ||
         is(std::type_identity<openvdb::Vec3SGrid>{}, ISOEXTRACT_F32) ||
         is(std::type_identity<openvdb::Vec3DGrid>{}, ISOEXTRACT_F64) ||
         is(std::type_identity<openvdb::Vec3IGrid>{}, ISOEXTRACT_I32);
}

template <class Grid>
constexpr bool kIsVector = openvdb::VecTraits<typename Grid::ValueType>::IsVec;

// Sample type of a grid's values, except for lengths of integer vectors.
template <class Value>
struct SampleOf {
  using type = Value;
};
template <>
struct SampleOf<bool> {
  using type = std::uint8_t;
};
template <>
struct SampleOf<std::int64_t> {
  using type = double;
};
template <class Number>
struct SampleOf<openvdb::math::Vec3<Number>> {
  using type = Number;
};

// Converts a value of a grid to a sample. Sets `rounded` if an int64 is beyond 2^53.
template <class T>
struct Conversion {
  Part part = Part::all;
  bool* rounded = nullptr;

  T operator()(const auto& value) const {
    if constexpr (requires { value[2]; }) {
      switch (part) {
        case Part::x: return static_cast<T>(value[0]);
        case Part::y: return static_cast<T>(value[1]);
        case Part::z: return static_cast<T>(value[2]);
        default: {
          const openvdb::Vec3d vector(value);
          return static_cast<T>(vector.length());
        }
      }
    } else if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::int64_t>) {
      constexpr std::int64_t kMostExact = std::int64_t{1} << 53;
      if (value > kMostExact || value < -kMostExact) *rounded = true;
      return static_cast<T>(value);
    } else {
      return static_cast<T>(value);
    }
  }
};

struct Entry {
  std::string stored_name;  // unique name, by which OpenVDB reads it
  std::string name;
  std::string type;
  Part part = Part::all;
  std::int32_t sample_type = kNotScalar;
  bool is_in_frustum = false;
  double spacing = 0;  // of the grid that replaces a frustum
};

struct Listed {
  std::string path;
  std::vector<Entry> entries;
  std::vector<isoextract_volume_grid> grids;
};

// Returns the shortest edge of the voxel at a frustum's center; 0 if the transform is not a frustum.
double frustum_spacing(const openvdb::math::Transform& transform) {
  const auto map = transform.constMap<openvdb::math::NonlinearFrustumMap>();
  if (map == nullptr) return 0;
  const openvdb::Vec3d middle = map->getBBox().getCenter();
  const openvdb::Vec3d edges = transform.voxelSize(middle);
  const double least = std::min({std::abs(edges.x()), std::abs(edges.y()), std::abs(edges.z())});
  return std::isfinite(least) ? least : 0;
}

void add_grid(Listed& listed, const std::string& stored_name, const openvdb::GridBase& grid) {
  const auto add = [&](Part part, const char* suffix, std::int32_t sample_type) {
    Entry entry;
    entry.stored_name = stored_name;
    entry.name = (grid.getName().empty() ? stored_name : grid.getName()) + suffix;  // not all writers repeat the name
                                                                                    // in the grid
    entry.type = grid.valueType();
    entry.part = part;
    entry.is_in_frustum = !grid.transform().isLinear();
    if (entry.is_in_frustum) {
      entry.spacing = frustum_spacing(grid.transform());
      if (entry.spacing == 0) {
        entry.type += " with an unknown placement";
        sample_type = kNotScalar;
      }
    }
    entry.sample_type = entry.is_in_frustum && sample_type != kNotScalar ? kFloat : sample_type;
    isoextract_volume_grid told{};
    told.kind = grid.getGridClass() == openvdb::GRID_LEVEL_SET ? ISOEXTRACT_LEVEL_SET : ISOEXTRACT_DENSITY;
    told.is_sparse = 1;
    if (entry.is_in_frustum) {
      for (int axis = 0; axis < 3; ++axis) told.index_to_world[5 * axis] = entry.spacing;
    } else {
      put_transform(grid.transform(), told.index_to_world);
      const auto low = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN);
      const auto high = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
      const auto voxels = grid.getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_VOXEL_COUNT);
      if (low && high && voxels && voxels->value() >= 0) {
        told.has_counts = 1;
        told.active_voxels = static_cast<std::uint64_t>(voxels->value());
        for (int axis = 0; axis < 3; ++axis) {
          told.active_min[axis] = low->value()[axis];
          told.active_max[axis] = high->value()[axis];
        }
      }
    }
    told.sample_type = entry.sample_type;
    listed.entries.push_back(std::move(entry));
    listed.grids.push_back(told);
  };
  const bool known = visit_grid_type(grid, [&]<class Grid>(std::type_identity<Grid>, std::int32_t sample_type) {
    if constexpr (kIsVector<Grid>) {
      for (const auto& [part, suffix] : kVectorParts) {
        const bool is_root = part == Part::length && sample_type == ISOEXTRACT_I32;
        add(part, suffix, is_root ? kDouble : sample_type);
      }
    } else {
      add(Part::all, "", sample_type);
    }
  });
  if (!known) add(Part::all, "", kNotScalar);
}

std::unique_ptr<Listed> list_file(openvdb::io::File& file) {
  auto listed = std::make_unique<Listed>();
  for (auto name = file.beginName(); name != file.endName(); ++name) {
    try {
      add_grid(*listed, *name, *file.readGridMetadata(*name));
    } catch (const openvdb::Exception& unknown) {
      // A type unknown to OpenVDB; other grids stay readable.
      listed->entries.push_back({*name, *name, unknown.what(), Part::all, kNotScalar, false, 0});
      listed->grids.emplace_back();
    }
  }
  for (std::size_t i = 0; i < listed->grids.size(); ++i) {
    listed->grids[i].name = listed->entries[i].name.c_str();
    listed->grids[i].type_name = listed->entries[i].type.c_str();
    listed->grids[i].world_space = "";
    listed->grids[i].has_placement = 1;
    listed->grids[i].slope = 1;
    listed->grids[i].components = 1;
    listed->grids[i].volumes = 1;
  }
  return listed;
}

std::uint64_t size_of(const char* path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  return file ? static_cast<std::uint64_t>(file.tellg()) : 0;
}

// Returns a float grid with the same topology and transform.
template <class Grid>
openvdb::FloatGrid::Ptr as_floats(const Grid& grid, const Conversion<float>& convert, Reserved& memory) {
  memory.take(grid.tree().leafCount() * kLeafBytes + (std::uint64_t{1} << 20));
  auto floats = openvdb::FloatGrid::create(convert(grid.background()));
  visit_tiles(grid.tree(), [&](const auto& tile) {
    const float value = convert(tile.getValue());
    if (!tile.isValueOn() && value == floats->background()) return;
    floats->tree().addTile(static_cast<openvdb::Index>(tile.getLevel()), tile.getCoord(), value, tile.isValueOn());
  });
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    auto* to = floats->tree().touchLeaf(leaf->origin());
    for (openvdb::Index i = 0; i < kLeafValues; ++i) to->setValueOnly(i, convert(leaf->getValue(i)));
    to->setValueMask(leaf->getValueMask());
  }
  floats->setTransform(grid.transform().copy());
  floats->setGridClass(grid.getGridClass());  // decides whether signs are flood filled
  return floats;
}

// Resamples a grid in a frustum to a cubic grid aligned with the world's axes. OpenVDB's own resampler does not compile
// as C++20 with oneTBB.
class Resampling {
 public:
  Resampling(const openvdb::FloatGrid& source, double spacing)
      : source_(source), target_(openvdb::FloatGrid::create(source.background())) {
    target_->setTransform(openvdb::math::Transform::createLinearTransform(spacing));
    target_->setGridClass(source.getGridClass());
  }

  openvdb::FloatGrid::Ptr run(const isoextract_plugin_host& host, Reserved& memory) {
    HostInterrupter interrupter(host);
    memory.take(bytes());
    visit_source([&](const openvdb::CoordBBox& box) {
      interrupter.check();
      const openvdb::CoordBBox leaves = leaves_of(box);
      for (const openvdb::Coord& at : leaves) target_->tree().touchLeaf({8 * at.x(), 8 * at.y(), 8 * at.z()});
    });
    openvdb::tree::LeafManager<openvdb::FloatTree> leaves(target_->tree());
    leaves.foreach ([&](Leaf& leaf, std::size_t) {
      if (!interrupter.wasInterrupted()) sample(leaf);
    });
    interrupter.check();
    if (target_->getGridClass() == openvdb::GRID_LEVEL_SET) {
      openvdb::tools::signedFloodFill(target_->tree());
      openvdb::tools::pruneLevelSet(target_->tree());
    } else {
      openvdb::tools::pruneInactive(target_->tree());
    }
    return target_;
  }

 private:
  using Leaf = openvdb::FloatTree::LeafNodeType;

  // Calls use(box) for all leaves and active tiles.
  template <class F>
  void visit_source(F&& use) const {
    for (auto leaf = source_.tree().cbeginLeaf(); leaf; ++leaf) use(leaf->getNodeBoundingBox());
    visit_tiles(source_.tree(), [&](const auto& tile) {
      if (!tile.isValueOn()) return;
      openvdb::CoordBBox box;
      tile.getBoundingBox(box);
      use(box);
    });
  }

  // Returns the bounds of a box, widened by a voxel, in leaves of the target. A frustum maps straight edges to straight
  // edges, so corners suffice.
  [[nodiscard]] openvdb::BBoxd image_of(const openvdb::CoordBBox& box) const {
    openvdb::BBoxd image;
    for (int corner = 0; corner < 8; ++corner) {
      const openvdb::Vec3d p((corner & 1) != 0 ? box.max().x() + 1.0 : box.min().x() - 1.0,
                             (corner & 2) != 0 ? box.max().y() + 1.0 : box.min().y() - 1.0,
                             (corner & 4) != 0 ? box.max().z() + 1.0 : box.min().z() - 1.0);
      image.expand(target_->worldToIndex(source_.indexToWorld(p)) / 8.0);
    }
    return image;
  }
  [[nodiscard]] openvdb::CoordBBox leaves_of(const openvdb::CoordBBox& box) const {
    const openvdb::BBoxd image = image_of(box);
    return {openvdb::Coord::floor(image.min()), openvdb::Coord::floor(image.max())};
  }

  // Returns an upper bound for the memory of the result. Throws if it is too far from the world's origin.
  [[nodiscard]] std::uint64_t bytes() const {
    const auto leaves_in = [&](const openvdb::CoordBBox& box) {
      constexpr double kMostIndex = 1 << 26;  // in leaves
      const openvdb::BBoxd image = image_of(box);
      for (int axis = 0; axis < 3; ++axis) {
        if (!(image.min()[axis] > -kMostIndex && image.max()[axis] < kMostIndex)) {
          throw PluginError("expected a frustum within 2^29 voxels of the world's origin");
        }
      }
      const openvdb::Vec3d size = image.extents() + openvdb::Vec3d(2.0);
      return size.x() * size.y() * size.z();
    };
    double sum = 0;
    openvdb::CoordBBox all;
    visit_source([&](const openvdb::CoordBBox& box) {
      sum += leaves_in(box);
      all.expand(box);
    });
    if (!all.empty()) sum = std::min(sum, leaves_in(all));
    // A quarter more for the nodes above the leaves, of which there is at least one.
    const double most = sum * static_cast<double>(kLeafBytes) * 1.25 + (1 << 20);
    constexpr double kMost = 1e18;
    return most < kMost ? static_cast<std::uint64_t>(most) : ~std::uint64_t{0};
  }

  void sample(Leaf& leaf) const {
    const auto values = source_.getConstAccessor();
    for (openvdb::Index n = 0; n < kLeafValues; ++n) {
      const openvdb::Vec3d world = target_->indexToWorld(leaf.offsetToGlobalCoord(n));
      const openvdb::Vec3d at = source_.worldToIndex(world);
      constexpr double kFar = 1e9;  // behind the frustum's apex positions are undefined
      if (!(std::abs(at.x()) < kFar && std::abs(at.y()) < kFar && std::abs(at.z()) < kFar)) continue;
      float value = 0;
      if (openvdb::tools::BoxSampler::sample(values, at, value)) leaf.setValueOn(n, value);
    }
  }

  const openvdb::FloatGrid& source_;
  openvdb::FloatGrid::Ptr target_;
};

std::string spacing_note(const Entry& entry) {
  std::array<char, 64> number{};
  std::snprintf(number.data(), number.size(), "%.6g", entry.spacing);
  return "the grid lies in a frustum; the reader resamples it trilinearly to cubic voxels with a spacing of " +
         std::string(number.data());
}

void read_grid(openvdb::io::File& file, const char* path, const Entry& entry, const isoextract_plugin_host& host,
               SparseStore& store) {
  Reserved for_grid(host);
  const auto told = file.readGridMetadata(entry.stored_name)
                        ->getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_MEM_BYTES);
  // Without a stated size, assumes four times the file's size until the grid is read.
  for_grid.take(told && told->value() > 0 ? static_cast<std::uint64_t>(told->value()) : 4 * size_of(path));
  openvdb::GridBase::Ptr grid = file.readGrid(entry.stored_name);
  for_grid.set(grid->memUsage());
  Reserved for_samples(host);
  bool rounded = false;
  visit_grid_type(*grid, [&]<class Grid>(std::type_identity<Grid>, std::int32_t) {
    const auto& typed = static_cast<const Grid&>(*grid);
    if (entry.is_in_frustum) {
      Reserved for_floats(host);
      Reserved for_target(host);
      const auto floats = as_floats(typed, {entry.part, &rounded}, for_floats);
      const auto target = Resampling(*floats, entry.spacing).run(host, for_target);
      copy_tree_to_store<float>(target->tree(), ISOEXTRACT_F32, for_samples, store, [](float value) { return value; });
      store.note = spacing_note(entry);
      return;
    }
    const auto put = [&]<class T>(T) {
      copy_tree_to_store<T>(typed.tree(), entry.sample_type, for_samples, store, Conversion<T>{entry.part, &rounded});
    };
    if constexpr (std::is_same_v<Grid, openvdb::Vec3IGrid>) {
      if (entry.part == Part::length) return put(double{});
    }
    put(typename SampleOf<typename Grid::ValueType>::type{});
  });
  if (rounded) store.note += std::string(store.note.empty() ? "" : "; ") + "the reader rounds integers beyond 2^53";
  for_samples.keep();
}

int probe(const unsigned char* start, std::size_t bytes, const char* /*path*/) {
  constexpr std::array<unsigned char, 8> kStart{' ', 'B', 'D', 'V', 0, 0, 0, 0};
  return bytes >= kStart.size() && std::equal(kStart.begin(), kStart.end(), start) ? 1 : 0;
}

int list(const isoextract_volume_request* request, const isoextract_plugin_host* /*host*/,
         isoextract_volume_list* list) {
  return catch_exceptions([&] {
    openvdb::io::File file(request->path);
    file.setCopyMaxBytes(0);
    file.open(false);
    auto listed = list_file(file);
    listed->path = request->path;
    *list = {};
    list->grids = listed->grids.data();
    list->count = listed->grids.size();
    list->owner = listed.get();
    static_cast<void>(listed.release());
  });
}

void free_list(isoextract_volume_list* list) { delete static_cast<Listed*>(list->owner); }

int open(const isoextract_volume_list* list, const isoextract_volume_selection* selection,
         const isoextract_plugin_host* host, isoextract_volume_samples* samples) {
  return catch_exceptions([&] {
    const std::string& path = static_cast<const Listed*>(list->owner)->path;
    openvdb::io::File file(path);
    file.setCopyMaxBytes(0);
    file.open(false);
    const auto listed = list_file(file);
    if (selection->grid >= listed->entries.size())
      throw PluginError("the file changed during the run: a grid that it listed is missing");
    auto store = std::make_unique<SparseStore>();
    read_grid(file, path.c_str(), listed->entries[selection->grid], *host, *store);
    *samples = {0, &store->samples, 0, 0, store->note.c_str(), store.get()};
    static_cast<void>(store.release());
  });
}

void free_samples(isoextract_volume_samples* samples) { delete static_cast<SparseStore*>(samples->owner); }

const char* error_text() { return problem.c_str(); }

constexpr isoextract_volume_plugin_v4 kPlugin{
    ISOEXTRACT_VOLUME_PLUGIN_VERSION, "openvdb", "OpenVDB", probe, list, free_list, open, free_samples, error_text};

}  // namespace

const isoextract_volume_plugin_v4* isoextract_volume_plugin() { return &kPlugin; }
