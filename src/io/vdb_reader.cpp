// OpenVDB. The library reads transforms and trees; the only file that includes it, for it is slow to compile.
#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <tbb/parallel_sort.h>

#include "io/grid_choice.hpp"
#include "io/vdb_header.hpp"
#include "io/volume_format.hpp"

namespace isoextract {
namespace {

constexpr std::string_view kLevelSetClass = "level set";
constexpr std::string_view kFogClass = "fog volume";

void initialize_library() {
  static const bool done = [] {
    openvdb::initialize();
    return true;
  }();
  static_cast<void>(done);
}

// Calls use(std::type_identity<Tree>{}) with the tree type of a scalar grid; false for all other types.
template <class F>
bool visit_scalar_tree(const std::string& tree_type, F&& use) {
  const auto try_tree = [&]<class Tree>(std::type_identity<Tree> tree) {
    if (tree_type != Tree::treeType()) return false;
    use(tree);
    return true;
  };
  return try_tree(std::type_identity<openvdb::FloatTree>{}) || try_tree(std::type_identity<openvdb::DoubleTree>{}) ||
         try_tree(std::type_identity<openvdb::Int32Tree>{});
}

glm::ivec3 to_glm(const openvdb::Coord& c) { return {c.x(), c.y(), c.z()}; }

IndexBox to_index_box(const openvdb::CoordBBox& box) { return {to_glm(box.min()), to_glm(box.max())}; }

// Blocks and tiles of a tree. Blocks point into the tree's leaves.
template <class Tree>
class TreeWalk {
 public:
  explicit TreeWalk(const Tree& tree) : tree_(tree), background_(tree.background()) {}

  SparseSamples samples() {
    using Value = typename Tree::ValueType;
    result_.type = sample_type_of<Value>();
    result_.background = static_cast<double>(background_);
    result_.blocks.reserve(tree_.leafCount());
    visit(tree_.root());
    tbb::parallel_sort(result_.blocks, [](const SparseBlock& a, const SparseBlock& b) {
      return std::tie(a.origin.x, a.origin.y, a.origin.z) < std::tie(b.origin.x, b.origin.y, b.origin.z);
    });
    openvdb::CoordBBox box;
    result_.active_voxels = tree_.activeVoxelCount();
    if (tree_.evalActiveVoxelBoundingBox(box)) result_.active_box = to_index_box(box);
    return std::move(result_);
  }

 private:
  // The origin of a node or tile of `size`, checked: the walkers behind rely on it, and on one more voxel all round.
  static glm::ivec3 origin_of(const openvdb::Coord& c, int size) {
    for (int axis = 0; axis < 3; ++axis) {
      if (c[axis] % size != 0) {
        throw VdbDamaged(fmt::format("a node of {} voxels a side at index {} along axis {}", size, c[axis], axis));
      }
      if (c[axis] < -kMaxSparseIndex || c[axis] >= kMaxSparseIndex) {
        throw VdbDamaged(fmt::format("voxels at index {} along axis {}: the limit is 2^29", c[axis], axis));
      }
    }
    return to_glm(c);
  }

  template <class Node>
  void visit(const Node& node) {
    using Child = typename Node::ChildNodeType;
    constexpr int kChildSize = static_cast<int>(Child::DIM);
    for (auto tile = node.cbeginValueAll(); tile; ++tile) add_tile(*tile, tile.getCoord(), kChildSize);
    for (auto child = node.cbeginChildOn(); child; ++child) {
      const glm::ivec3 origin = origin_of(child.getCoord(), kChildSize);
      if constexpr (Child::LEVEL == 0) {
        result_.blocks.push_back({origin, child->buffer().data()});
      } else {
        visit(*child);
      }
    }
  }

  void add_tile(typename Tree::ValueType value, const openvdb::Coord& coord, int size) {
    const bool both_nan = value != value && background_ != background_;
    if (value == background_ || both_nan) return;
    result_.tiles.push_back({origin_of(coord, size), size, static_cast<double>(value)});
  }

  const Tree& tree_;
  typename Tree::ValueType background_;
  SparseSamples result_;
};

// What a tree needs once its leaves have their values.
template <class Tree>
std::uint64_t tree_bytes(const Tree& tree) {
  using Leaf = typename Tree::LeafNodeType;
  using Lower = typename Tree::RootNodeType::ChildNodeType::ChildNodeType;
  using Upper = typename Tree::RootNodeType::ChildNodeType;
  const std::vector<openvdb::Index32> counts = tree.nodeCount();  // leaves first
  const std::uint64_t leaf = sizeof(Leaf) + Leaf::SIZE * sizeof(typename Tree::ValueType) + sizeof(SparseBlock);
  return counts.at(0) * leaf + counts.at(1) * sizeof(Lower) + counts.at(2) * sizeof(Upper);
}

// Leaves the stream at the grid's tree. OpenVDB multiplies row vectors from the left: row a of its matrix is the image
// of axis a.
Frame read_transform_of(VdbStream& stream, const VdbHeader& header, const VdbGridRecord& record) {
  openvdb::io::setVersion(stream, {header.library_major, header.library_minor}, header.file_version);
  openvdb::io::setDataCompression(stream, record.compression);
  stream.expect_no_tree();
  stream.seek(record.transform_position);
  static_cast<void>(stream.read_name());  // only to check its length: the library reads it again
  stream.seek(record.transform_position);
  Frame frame;
  try {
    openvdb::math::Transform transform;
    transform.read(stream);
    if (!transform.isLinear()) {
      frame.problem = fmt::format("expected a linear transform, found {}", transform.mapType());
      return frame;
    }
    const openvdb::Mat4d matrix = transform.baseMap()->getAffineMap()->getMat4();
    for (int axis = 0; axis < 3; ++axis) {
      for (int row = 0; row < 3; ++row) frame.index_to_world.linear[axis][row] = matrix(axis, row);
      frame.index_to_world.offset[axis] = matrix(3, axis);
    }
  } catch (const openvdb::ArithmeticError& error) {
    // Thrown for a matrix without an inverse, when it was read.
    frame.problem = fmt::format("expected a transform with an inverse: {}", error.what());
  }
  return frame;
}

// Nodes, masks and tiles; the leaves have no values yet.
template <class Tree>
typename Tree::Ptr read_topology(VdbStream& stream, const VdbGridRecord& record) {
  using Value = typename Tree::ValueType;
  const bool half = record.half && std::is_floating_point_v<Value>;
  stream.expect_tree({sizeof(Value), half ? sizeof(Half) : sizeof(Value), half, record.compression});

  // The library would print a warning and go on.
  const std::uint64_t begin = stream.position();
  const auto buffers = stream.read_value<std::int32_t>();
  if (buffers != 1) throw VdbDamaged(fmt::format("expected one buffer in a tree, found {}", buffers));
  stream.seek(begin);

  auto tree = std::make_shared<Tree>();
  tree->readTopology(stream, record.half);
  return tree;
}

// The record whose tree belongs to `record`: its own, or that of the grid it is an instance of.
const VdbGridRecord& tree_owner(const VdbHeader& header, const VdbGridRecord& record) {
  if (record.instance_parent.empty()) return record;
  const auto parent = std::ranges::find(header.grids, record.instance_parent, &VdbGridRecord::unique_name);
  if (parent == header.grids.end() || !parent->instance_parent.empty() || parent->tree_type != record.tree_type) {
    throw VdbDamaged(fmt::format("grid '{}' shares the tree of a grid that is not there", record.name));
  }
  return *parent;
}

// For files whose writer did not store these counts.
void count_voxels(VdbStream& stream, const VdbHeader& header, VdbGridRecord& record) {
  visit_scalar_tree(record.tree_type, [&]<class Tree>(std::type_identity<Tree>) {
    const VdbGridRecord& owner = tree_owner(header, record);
    static_cast<void>(read_transform_of(stream, header, owner));
    const auto tree = read_topology<Tree>(stream, owner);
    openvdb::CoordBBox box;
    record.voxels = tree->activeVoxelCount();
    record.box = tree->evalActiveVoxelBoundingBox(box) ? to_index_box(box) : IndexBox{};
  });
}

std::vector<GridInfo> describe_grids(VdbStream& stream, VdbHeader& header) {
  std::map<std::string, int> counts;
  std::vector<GridInfo> grids;
  for (VdbGridRecord& record : header.grids) {
    if (!record.voxels || !record.box) count_voxels(stream, header, record);
    GridInfo info;
    info.name = record.name;
    info.index_of_name = counts[record.name]++;
    info.type = record.value_type;
    info.scalar = visit_scalar_tree(record.tree_type, [](auto) {});
    if (record.grid_class == kLevelSetClass) info.kind = FieldKind::level_set;
    if (record.grid_class == kFogClass) info.kind = FieldKind::density;
    info.box = record.box.value_or(IndexBox{});
    info.voxels = record.voxels.value_or(0);
    grids.push_back(std::move(info));
  }
  for (GridInfo& info : grids) info.name_repeats = counts[info.name] > 1;
  return grids;
}

Result<ScalarField> read_grid(const InputFile& file, VdbStream& stream, const VdbHeader& header,
                              const VdbGridRecord& record, const ReadOptions& options) {
  ScalarField field;
  field.source = file.name();
  field.name = record.name;
  field.format = "OpenVDB";
  if (record.grid_class == kLevelSetClass) field.kind = FieldKind::level_set;

  Frame frame = read_transform_of(stream, header, record);
  const VdbGridRecord& owner = tree_owner(header, record);
  if (&owner != &record) static_cast<void>(read_transform_of(stream, header, owner));
  Result<void> fits;
  visit_scalar_tree(record.tree_type, [&]<class Tree>(std::type_identity<Tree>) {
    const auto tree = read_topology<Tree>(stream, owner);
    fits = check_memory(tree_bytes(*tree), options.limits,
                        fmt::format("{}: the {} leaf nodes of grid '{}'", file.name(), tree->leafCount(), record.name));
    if (!fits) return;
    tree->readBuffers(stream, owner.half);
    SparseSamples samples = TreeWalk<Tree>(*tree).samples();
    samples.owner = tree;
    field.samples = std::move(samples);
  });
  if (!fits) return tl::unexpected(fits.error());
  if (auto placed = place_field(field, frame, options); !placed) return tl::unexpected(placed.error());
  return field;
}

// Calls work() and turns what the library throws into an error that names the file.
template <class F>
auto with_messages(const InputFile& file, F&& work) -> decltype(work()) {
  if (!looks_like_vdb(first_bytes(file, kDetectionBytes).value_or(std::vector<std::byte>{}))) {
    return fail_magic(file, "a VDB file", "' BDV'");
  }
  try {
    return work();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    return fail(ErrorKind::input, fmt::format("{}: the VDB file is damaged or not supported: {}", file.name(),
                                              printable(std::string_view(error.what()), 300)));
  }
}

}  // namespace

bool looks_like_vdb(std::span<const std::byte> content) {
  return starts_with(content, std::string_view(" BDV\0\0\0\0", 8));
}

Result<std::vector<GridInfo>> list_vdb_grids(const InputFile& file) {
  return with_messages(file, [&]() -> Result<std::vector<GridInfo>> {
    initialize_library();
    VdbStream stream(file);
    VdbHeader header = read_vdb_header(stream);
    return describe_grids(stream, header);
  });
}

Result<ScalarField> read_vdb(const InputFile& file, const ReadOptions& options) {
  return with_messages(file, [&]() -> Result<ScalarField> {
    initialize_library();
    if (options.progress != nullptr) options.progress->begin("reading", 0);
    VdbStream stream(file, options.progress);
    VdbHeader header = read_vdb_header(stream);
    const std::vector<GridInfo> grids = describe_grids(stream, header);
    const auto chosen = choose_grid(file.name(), grids, options.grid);
    if (!chosen) return tl::unexpected(chosen.error());
    auto field = read_grid(file, stream, header, header.grids[*chosen], options);
    if (!field) return field;
    if (!options.grid && grids.size() > 1) {
      field->notes.push_back(fmt::format("grid '{}' of {} was chosen: it is the only scalar one",
                                         grid_label(grids[*chosen]), grids.size()));
    }
    if (header.file_version > openvdb::OPENVDB_FILE_VERSION) {
      field->notes.push_back(fmt::format("the file's version {} is newer than {}, the latest that OpenVDB {} knows",
                                         header.file_version, openvdb::OPENVDB_FILE_VERSION,
                                         OPENVDB_LIBRARY_VERSION_STRING));
    }
    return field;
  });
}

}  // namespace isoextract
