// Particles of OpenVDB's point grids: positions relative to a voxel, and named attributes.
#include <malloc.h>

#include <memory>

#include <openvdb/io/File.h>
#include <openvdb/points/AttributeArray.h>
#include <openvdb/points/AttributeGroup.h>
#include <openvdb/points/PointCount.h>
#include <openvdb/points/PointDataGrid.h>

#include <particle_plugin.h>
#include "openvdb_parts.hpp"

namespace {

using namespace isoextract_openvdb;  // NOLINT(google-build-using-namespace): all of this file is of it
namespace points = openvdb::points;
using Leaf = points::PointDataTree::LeafNodeType;

constexpr const char* kPosition = "P";

// An open grid and its description.
struct Opened {
  points::PointDataGrid::Ptr grid;
  std::vector<std::string> attributes;  // names
  std::vector<std::string> types;
  std::vector<isoextract_particle_quantity> quantities;
};

// Blender's liquid caches store flags of particles as 16-bit integers ("int32_trnc"), a type that OpenVDB defines and
// does not register.
void register_attribute_types() {
  using Truncated = points::TypedAttributeArray<std::int32_t, points::TruncateCodec>;
  [[maybe_unused]] static const bool is_done = [] {
    if (!Truncated::isRegistered()) Truncated::registerType();
    return true;
  }();
}

// Calls use(Value{}, components) for a numeric attribute type; returns false for all others.
template <class F>
bool visit_attribute(const std::string& type, F&& use) {
  if (type == "float") return use(float{}, 1), true;
  if (type == "double") return use(double{}, 1), true;
  if (type == "bool") return use(bool{}, 1), true;
  if (type == "int8") return use(std::int8_t{}, 1), true;
  if (type == "int16") return use(std::int16_t{}, 1), true;
  if (type == "int32") return use(std::int32_t{}, 1), true;
  if (type == "int64") return use(std::int64_t{}, 1), true;
  if (type == "vec3s") return use(openvdb::Vec3f{}, 3), true;
  if (type == "vec3d") return use(openvdb::Vec3d{}, 3), true;
  if (type == "vec3i") return use(openvdb::Vec3i{}, 3), true;
  return false;
}

void put(float*& to, const auto& value) {
  if constexpr (requires { value[2]; }) {
    for (int i = 0; i < 3; ++i) *to++ = static_cast<float>(value[i]);
  } else {
    *to++ = static_cast<float>(value);
  }
}

// OpenVDB allocates the bytes that the file states for an array, but reads as many as its values need. Rejects arrays
// whose values would be read from beyond that memory.
void check_bytes(const points::AttributeArray& array, const std::string& name) {
  if (array.size() == 0) return;
  const std::uint64_t values = array.isUniform() ? 1 : std::uint64_t{array.size()} * array.stride();
  const char* data = array.constDataAsByteArray();
  const std::size_t there = data == nullptr ? 0 : ::malloc_usable_size(const_cast<char*>(data));
  if (!array.hasConstantStride() || values > there / array.storageTypeSize()) {
    throw PluginError("the file is damaged: expected " + std::to_string(values) + " values of '" + name +
                      "' in a leaf, found " + std::to_string(there / array.storageTypeSize()));
  }
}

// Returns whether `wanted` is the name of a grid, also as a path: "/drops".
bool is_name(std::string_view wanted, std::string_view name) {
  return wanted == name || (wanted.starts_with('/') && wanted.substr(1) == name);
}

// Returns the unique name, as file.beginName() lists it, of the wanted point grid, or of the only one. The unique name
// has precedence over other grids with this name.
std::string chosen_grid(openvdb::io::File& file, const char* wanted) {
  std::vector<std::string> sets;
  std::vector<std::string> called;  // the sets with the wanted name
  std::string all;
  std::string others;
  for (auto name = file.beginName(); name != file.endName(); ++name) {
    openvdb::GridBase::Ptr grid;
    try {
      grid = file.readGridMetadata(*name);
    } catch (const openvdb::Exception&) {
      continue;  // unknown to OpenVDB, so not a point grid
    }
    if (!grid->isType<points::PointDataGrid>()) {
      others += (others.empty() ? "" : ", ") + grid->type() + " '" + *name + "'";
      continue;
    }
    if (wanted != nullptr && *name == wanted) return *name;
    if (wanted != nullptr && (is_name(wanted, *name) || is_name(wanted, grid->getName()))) called.push_back(*name);
    all += (sets.empty() ? "'" : ", '") + *name + "'";
    sets.push_back(*name);
  }
  if (sets.empty()) {
    throw PluginError("expected a grid of points, found " + (others.empty() ? std::string("no grid") : others));
  }
  if (called.size() == 1) return called.front();
  if (called.size() > 1) {
    throw PluginError(std::to_string(called.size()) + " grids of points are named '" + std::string(wanted) +
                      "'; there is " + all);
  }
  if (wanted != nullptr) throw PluginError("there is no grid of points '" + std::string(wanted) + "'; there is " + all);
  if (sets.size() > 1) throw PluginError("expected the name of one of the grids of points: " + all);
  return sets.front();
}

void describe_attributes(Opened& opened) {
  const auto first = opened.grid->tree().cbeginLeaf();
  if (!first) return;
  const points::AttributeSet& set = first->attributeSet();
  std::vector<std::tuple<std::size_t, std::string, std::string>> found;
  for (const auto& [name, position] : set.descriptor().map()) {
    if (name == kPosition) continue;
    if (points::isGroup(*set.getConst(position))) continue;
    found.emplace_back(position, name, set.getConst(position)->type().first);
  }
  std::ranges::sort(found);
  for (auto& [position, name, type] : found) {
    opened.attributes.push_back(name);
    opened.types.push_back(type);
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    const points::AttributeArray& array = *set.getConst(std::get<0>(found[i]));
    std::uint64_t components = 1;
    const bool is_numeric =
        array.hasConstantStride() &&
        visit_attribute(opened.types[i], [&](auto, std::uint64_t values) { components = values * array.stride(); });
    opened.quantities.push_back({opened.attributes[i].c_str(), opened.types[i].c_str(), components, is_numeric ? 1 : 0,
                                 ISOEXTRACT_KIND_NOT_SAID});
  }
}

std::unique_ptr<Opened> open_points(const char* path, const char* wanted) {
  openvdb::io::File file(path);
  file.setCopyMaxBytes(0);
  file.open(false);
  auto opened = std::make_unique<Opened>();
  const auto grid = file.readGrid(chosen_grid(file, wanted));
  opened->grid = openvdb::gridPtrCast<points::PointDataGrid>(grid);
  if (opened->grid == nullptr) throw PluginError("expected a grid of points, found " + grid->type());
  for (auto leaf = opened->grid->tree().cbeginLeaf(); leaf; ++leaf) {
    // Invalid offsets in a damaged file would lead to reads beyond the arrays.
    const points::AttributeArray* places = leaf->attributeSet().getConst(kPosition);
    if (places == nullptr || places->type().first != "vec3s") throw PluginError("expected positions P of vec3s");
    openvdb::Index32 before = 0;
    for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
      const auto end = static_cast<openvdb::Index32>(leaf->getValue(i));
      if (end < before || end > places->size())
        throw PluginError("the file is damaged: a leaf refers to points that it does not have");
      before = end;
    }
    if (before != places->size()) throw PluginError("the file is damaged: a leaf has points that belong to no voxel");
    if (places->stride() != 1) throw PluginError("the file is damaged: expected one position per point");
    check_bytes(*places, kPosition);
  }
  describe_attributes(*opened);
  return opened;
}

Opened& opened_of(const isoextract_particle_file* file) { return *static_cast<Opened*>(file->owner); }

int open(const char* path, const char* grid, std::uint64_t frame, isoextract_particle_file* file) {
  return catch_exceptions([&] {
    register_attribute_types();
    *file = {};
    file->frames = 1;
    file->frame_name = file->length_unit = "";
    auto opened = std::make_unique<Opened>();
    if (frame == 0) {
      opened = open_points(path, grid);
      for (auto leaf = opened->grid->tree().cbeginLeaf(); leaf; ++leaf) {
        file->particles += leaf->attributeSet().getConst(kPosition)->size();
      }
      file->held_bytes = opened->grid->memUsage();
    }
    file->quantities = opened->quantities.data();
    file->quantity_count = opened->quantities.size();
    file->owner = opened.release();
  });
}

void close(isoextract_particle_file* file) { delete static_cast<Opened*>(file->owner); }

// Writes positions leaf by leaf in the tree's order, voxel by voxel within a leaf.
int positions(const isoextract_particle_file* file, double* values) {
  return catch_exceptions([&] {
    const points::PointDataGrid& grid = *opened_of(file).grid;
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
      const points::AttributeHandle<openvdb::Vec3f> place(leaf->constAttributeArray(kPosition));
      for (auto index = leaf->beginIndexAll(); index; ++index) {
        const openvdb::Vec3d world =
            grid.transform().indexToWorld(openvdb::Vec3d(place.get(*index)) + index.getCoord().asVec3d());
        values = std::copy_n(world.asPointer(), 3, values);
      }
    }
  });
}

int quantity(const isoextract_particle_file* file, std::size_t number, float* values) {
  return catch_exceptions([&] {
    const Opened& opened = opened_of(file);
    const std::string& name = opened.attributes[number];
    const std::string& type = opened.types[number];
    const std::uint64_t components = opened.quantities[number].components;
    for (auto leaf = opened.grid->tree().cbeginLeaf(); leaf; ++leaf) {
      const points::AttributeArray* array = leaf->attributeSet().getConst(name);
      // The file states a size for each array, and OpenVDB does not check indices against it.
      if (array != nullptr && array->size() != leaf->attributeSet().getConst(kPosition)->size()) {
        throw PluginError("the file is damaged: expected a value of '" + name + "' for each point of a leaf");
      }
      const bool known = array != nullptr && array->type().first == type &&
                         visit_attribute(type, [&]<class Value>(Value, std::uint64_t in_value) {
                           if (array->stride() * in_value != components) {
                             throw PluginError("expected the same number of values of '" + name + "' at every point");
                           }
                           check_bytes(*array, name);
                           const points::AttributeHandle<Value> handle(*array);
                           for (auto index = leaf->beginIndexAll(); index; ++index) {
                             for (openvdb::Index i = 0; i < handle.stride(); ++i) put(values, handle.get(*index, i));
                           }
                         });
      if (!known) throw PluginError("expected '" + name + "' of " + type + " at every point");
    }
  });
}

const char* error_text() { return problem.c_str(); }

constexpr isoextract_particle_plugin_v3 kPlugin{
    ISOEXTRACT_PARTICLE_PLUGIN_VERSION, "openvdb", open, close, positions, quantity, error_text};

}  // namespace

const isoextract_particle_plugin_v3* isoextract_particle_plugin() { return &kPlugin; }
