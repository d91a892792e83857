// Shared by the OpenVDB plug-ins: errors as texts, the host's memory, and trees as sparse samples.
#pragma once

#include <algorithm>
#include <cstdint>
#include <exception>
#include <new>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <openvdb/openvdb.h>
#include <openvdb/util/NullInterrupter.h>

#include <plugin_samples.h>

namespace isoextract_openvdb {

inline thread_local std::string problem;  // error text of this thread's last failed call

struct PluginError : std::exception {
  explicit PluginError(std::string words) : text(std::move(words)) {}
  [[nodiscard]] const char* what() const noexcept override { return text.c_str(); }
  std::string text;
};

// Calls work(). Returns 0 on success, and 1 after an exception, whose text `problem` then has in one line.
template <class F>
int catch_exceptions(F&& work) {
  try {
    openvdb::initialize();
    work();
    return 0;
  } catch (const PluginError& found) {
    problem = found.text;
  } catch (const std::bad_alloc&) {
    problem = "not enough memory";
  } catch (const std::exception& error) {
    problem = std::string("OpenVDB says: ") + error.what();
  } catch (...) {
    problem = "OpenVDB failed and gave no reason";
  }
  std::ranges::replace(problem, '\n', ' ');
  return 1;
}

// Memory reserved from the host; released on destruction unless it is kept.
class Reserved {
 public:
  explicit Reserved(const isoextract_plugin_host& host) : host_(host) {}
  Reserved(const Reserved&) = delete;
  Reserved& operator=(const Reserved&) = delete;
  ~Reserved() { host_.release(host_.self, bytes_); }

  void take(std::uint64_t bytes) {
    if (host_.reserve(host_.self, bytes) != 0)
      throw PluginError("not enough memory: the work needs " + std::to_string(bytes) + " bytes");
    bytes_ += bytes;
  }
  // Changes the total to `bytes`.
  void set(std::uint64_t bytes) {
    if (bytes > bytes_) return take(bytes - bytes_);
    host_.release(host_.self, bytes_ - bytes);
    bytes_ = bytes;
  }
  // Allocates memory for output samples, which the host reserves and owns.
  [[nodiscard]] void* allocate(std::uint64_t bytes) const {
    if (bytes == 0) return nullptr;
    void* memory = host_.allocate(host_.self, bytes);
    if (memory == nullptr) throw PluginError("not enough memory: the samples need " + std::to_string(bytes) + " bytes");
    return memory;
  }
  // Leaves the memory reserved until the host frees the call's results.
  void keep() { bytes_ = 0; }

 private:
  const isoextract_plugin_host& host_;
  std::uint64_t bytes_ = 0;
};

// Cancels OpenVDB's loops when the host asks for it. Pass it to OpenVDB as its base type, for which the library has
// template instances.
class HostInterrupter : public openvdb::util::NullInterrupter {
 public:
  explicit HostInterrupter(const isoextract_plugin_host& host) : host_(host) {}
  bool wasInterrupted(int /*percent*/ = -1) override { return host_.is_cancelled(host_.self) != 0; }
  void check() {
    if (wasInterrupted()) throw PluginError("cancelled");
  }

 private:
  const isoextract_plugin_host& host_;
};

constexpr std::size_t kLeafValues = 512;
// Bytes of a float leaf and its values, which are allocated separately.
constexpr std::uint64_t kLeafBytes = sizeof(openvdb::FloatTree::LeafNodeType) + kLeafValues * sizeof(float);

// Writes rows of world x, y, z. OpenVDB's matrix is transposed, as it multiplies row vectors.
inline void put_transform(const openvdb::math::Transform& transform, double* index_to_world) {
  const openvdb::Mat4d m = transform.baseMap()->getAffineMap()->getMat4();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) index_to_world[4 * row + column] = m[column][row];
  }
}

// Sparse samples; the blocks' values are in the host's memory.
struct SparseStore {
  std::vector<isoextract_sparse_block> blocks;
  std::vector<isoextract_sparse_tile> tiles;
  isoextract_sparse_samples samples{};
  std::string note;
};

// Calls use(tile) for every tile of a tree, active or not.
template <class Tree, class F>
void visit_tiles(const Tree& tree, F&& use) {
  auto tile = tree.cbeginValueAll();
  tile.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) use(tile);
}

// Copies a tree into `store`, with convert(value) as samples of type T. Reserves the memory.
template <class T, class Tree, class Convert>
void copy_tree_to_store(const Tree& tree, std::int32_t sample_type, Reserved& memory, SparseStore& store,
                        Convert&& convert) {
  using Leaf = typename Tree::LeafNodeType;
  const std::uint64_t leaf_count = tree.leafCount();
  memory.take(leaf_count * (sizeof(isoextract_sparse_block) + sizeof(const Leaf*)));
  std::vector<const Leaf*> leaves;
  leaves.reserve(leaf_count);
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) leaves.push_back(&*leaf);
  std::ranges::sort(leaves, [](const Leaf* a, const Leaf* b) { return a->origin() < b->origin(); });

  T* values = static_cast<T*>(memory.allocate(leaf_count * kLeafValues * sizeof(T)));
  store.blocks.reserve(leaf_count);
  for (const Leaf* leaf : leaves) {
    for (openvdb::Index i = 0; i < kLeafValues; ++i) values[i] = convert(leaf->getValue(i));
    const openvdb::Coord& o = leaf->origin();
    store.blocks.push_back({{o.x(), o.y(), o.z()}, values});
    values += kLeafValues;
  }

  const auto background = static_cast<double>(convert(tree.background()));
  visit_tiles(tree, [&](const auto& tile) {
    const auto value = static_cast<double>(convert(tile.getValue()));
    if (value == background) return;
    openvdb::CoordBBox box;
    tile.getBoundingBox(box);
    if (store.tiles.size() == store.tiles.capacity()) {
      memory.take(sizeof(isoextract_sparse_tile) * std::max<std::size_t>(store.tiles.size(), 64));
      store.tiles.reserve(2 * store.tiles.size() + 64);
    }
    store.tiles.push_back({{box.min().x(), box.min().y(), box.min().z()}, box.dim().x(), value});
  });

  isoextract_sparse_samples& samples = store.samples;
  samples = {sample_type, store.blocks.data(), store.blocks.size(), store.tiles.data(),     store.tiles.size(),
             background,  {0, 0, 0},           {-1, -1, -1},        tree.activeVoxelCount()};
  openvdb::CoordBBox active;
  if (tree.evalActiveVoxelBoundingBox(active)) {
    for (int axis = 0; axis < 3; ++axis) {
      samples.active_min[axis] = active.min()[axis];
      samples.active_max[axis] = active.max()[axis];
    }
  }
}

}  // namespace isoextract_openvdb
