#include "extract/detail/face_rectangles.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <utility>

#include "base/parallel.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {
namespace {

// Merges the faces of one plane that point one way. Rows come in rising order, and so do the runs of each row.
class PlaneSweep {
 public:
  PlaneSweep(int plane, bool upward, bool merges) : merges_(merges) {
    pattern_.plane = plane;
    pattern_.upward = upward;
  }

  // Adds the faces begin to end - 1 of the current row.
  void add(int begin, int end) {
    if (!runs_.empty() && runs_.back().end == begin) {
      runs_.back().end = end;
    } else {
      runs_.push_back({begin, end});
    }
  }

  void end_row(int row, ReservedList<FaceRectangle>& found) {
    if (!merges_) {
      for (const Run& run : runs_) {
        for (int u = run.begin; u < run.end; ++u) write({u, u + 1, row}, row + 1, found);
      }
      runs_.clear();
      return;
    }
    if (row != next_row_) close_all(found);
    next_row_ = row + 1;
    if (runs_.empty() && open_.empty()) return;
    still_open_.clear();
    std::size_t o = 0;
    for (const Run& run : runs_) {
      int rest = run.begin;
      for (; o < open_.size() && open_[o].begin < run.end; ++o) {
        const Open& rectangle = open_[o];
        if (rectangle.begin < run.begin || rectangle.end > run.end) {
          write(rectangle, row, found);
          continue;
        }
        if (rest < rectangle.begin) still_open_.push_back({rest, rectangle.begin, row});
        still_open_.push_back(rectangle);
        rest = rectangle.end;
      }
      if (rest < run.end) still_open_.push_back({rest, run.end, row});
    }
    for (; o < open_.size(); ++o) write(open_[o], row, found);
    std::swap(open_, still_open_);
    runs_.clear();
  }

  void close_all(ReservedList<FaceRectangle>& found) {
    for (const Open& rectangle : open_) write(rectangle, next_row_, found);
    open_.clear();
  }

 private:
  struct Run {
    int begin;
    int end;
  };
  struct Open {
    int begin;
    int end;
    int first_row;
  };

  void write(const Open& open, int end_row, ReservedList<FaceRectangle>& found) {
    FaceRectangle rectangle = pattern_;
    rectangle.low[0] = open.begin;
    rectangle.high[0] = open.end;
    rectangle.low[1] = open.first_row;
    rectangle.high[1] = end_row;
    found.add(rectangle);
  }

  FaceRectangle pattern_;
  bool merges_;
  int next_row_ = 0;
  std::vector<Run> runs_;
  std::vector<Open> open_;
  std::vector<Open> still_open_;
};

// The planes of one layer of chunks, a downward and an upward one for each voxel step.
class LayerSweeps {
 public:
  LayerSweeps(int axis, int first_voxel, VoxelFaces faces) {
    for (int t = 0; t < kVoxelChunk[axis]; ++t) {
      for (int upward = 0; upward < 2; ++upward) {
        sweeps_.emplace_back(first_voxel + t + upward, upward != 0, faces != VoxelFaces::plain);
      }
    }
  }

  // Returns the sweep for the faces of the voxels `t` steps into the layer.
  [[nodiscard]] PlaneSweep& at(int t, int upward) {
    return sweeps_[2 * static_cast<std::size_t>(t) + static_cast<std::size_t>(upward)];
  }

  void end_row(int row, ReservedList<FaceRectangle>& found) {
    for (PlaneSweep& sweep : sweeps_) sweep.end_row(row, found);
  }
  void end(ReservedList<FaceRectangle>& found) {
    for (PlaneSweep& sweep : sweeps_) sweep.close_all(found);
  }

 private:
  std::vector<PlaneSweep> sweeps_;
};

// A chunk and its two neighbors along an axis.
struct ChunkTriple {
  glm::ivec3 origin;
  const ChunkBits* self;
  const ChunkBits* before;
  const ChunkBits* after;
};

void add_runs(PlaneSweep& sweep, int x, std::uint64_t word) {
  while (word != 0) {
    const int begin = std::countr_zero(word);
    const int length = std::countr_one(word >> begin);
    sweep.add(x + begin, x + begin + length);
    if (begin + length == 64) return;
    word &= kAllBits << (begin + length);
  }
}

// Adds the faces across y or z: each word is a row of a plane.
void add_word_faces(LayerSweeps& sweeps, int axis, const ChunkTriple& chunk, int v) {
  const auto row = [&](int t) { return axis == 1 ? chunk_row(t, v) : chunk_row(v, t); };
  for (int t = 0; t < 8; ++t) {
    const std::uint64_t word = (*chunk.self)[row(t)];
    if (word == 0) continue;
    const std::uint64_t lower = t > 0 ? (*chunk.self)[row(t - 1)] : (*chunk.before)[row(7)];
    const std::uint64_t upper = t < 7 ? (*chunk.self)[row(t + 1)] : (*chunk.after)[row(0)];
    add_runs(sweeps.at(t, 0), chunk.origin.x, word & ~lower);
    add_runs(sweeps.at(t, 1), chunk.origin.x, word & ~upper);
  }
}

// Adds the faces across x: each bit of a word belongs to a plane of its own.
void add_bit_faces(LayerSweeps& sweeps, const ChunkTriple& chunk, int v) {
  for (int y = 0; y < 8; ++y) {
    const std::size_t row = chunk_row(y, v);
    const std::uint64_t word = (*chunk.self)[row];
    const int u = chunk.origin.y + y;
    for_each_bit(word & ~(word << 1 | (*chunk.before)[row] >> 63), [&](int t) { sweeps.at(t, 0).add(u, u + 1); });
    for_each_bit(word & ~(word >> 1 | (*chunk.after)[row] << 63), [&](int t) { sweeps.at(t, 1).add(u, u + 1); });
  }
}

// Returns the chunk numbers sorted by layer, then by row within the layer, then along u.
std::vector<std::int32_t> layer_order(const std::vector<VoxelChunk>& chunks, int axis) {
  std::vector<std::int32_t> order(chunks.size());
  for (std::size_t c = 0; c < order.size(); ++c) order[c] = static_cast<std::int32_t>(c);
  std::ranges::sort(order, {}, [&](std::int32_t c) {
    const glm::ivec3& origin = chunks[static_cast<std::size_t>(c)].origin;
    return std::tuple(origin[axis], origin[plane_v(axis)], origin[plane_u(axis)]);
  });
  return order;
}

struct Layer {
  int axis;
  const std::int32_t* begin;
  const std::int32_t* end;
};

void sweep_layer(const VoxelChunks& voxels, const Layer& layer, VoxelFaces faces, ReservedList<FaceRectangle>& found) {
  const int axis = layer.axis;
  const int v_axis = plane_v(axis);
  glm::ivec3 step(0);
  step[axis] = kVoxelChunk[axis];
  const auto chunk_at = [&](const std::int32_t* c) -> const VoxelChunk& {
    return voxels.chunks()[static_cast<std::size_t>(*c)];
  };
  LayerSweeps sweeps(axis, chunk_at(layer.begin).origin[axis], faces);
  std::vector<ChunkTriple> row;
  for (const std::int32_t* c = layer.begin; c != layer.end && !found.error();) {
    const int v0 = chunk_at(c).origin[v_axis];
    row.clear();
    for (; c != layer.end && chunk_at(c).origin[v_axis] == v0; ++c) {
      const VoxelChunk& chunk = chunk_at(c);
      const ChunkTriple triple{chunk.origin, chunk.bits, &voxels.at(chunk.origin - step),
                               &voxels.at(chunk.origin + step)};
      const bool within = triple.self == &full_chunk() && triple.before == triple.self && triple.after == triple.self;
      if (!within) row.push_back(triple);
    }
    for (int v = v0; v < v0 + 8; ++v) {
      for (const ChunkTriple& chunk : row) {
        if (axis == 0) {
          add_bit_faces(sweeps, chunk, v);
        } else {
          add_word_faces(sweeps, axis, chunk, v);
        }
      }
      sweeps.end_row(v, found);
    }
  }
  sweeps.end(found);
}

}  // namespace

Result<std::vector<LayerRectangles>> list_face_rectangles(const VoxelChunks& voxels, VoxelFaces faces,
                                                          const Context& context, const std::string& what) {
  const std::vector<VoxelChunk>& chunks = voxels.chunks();
  const auto memory = TRY(context.reserve(3 * chunks.size() * sizeof(std::int32_t), what));
  std::array<std::vector<std::int32_t>, 3> orders;
  for_each_index(3, [&](int axis) { orders[static_cast<std::size_t>(axis)] = layer_order(chunks, axis); });
  std::vector<Layer> layers;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<std::int32_t>& order = orders[static_cast<std::size_t>(axis)];
    const auto place = [&](std::int32_t c) { return chunks[static_cast<std::size_t>(c)].origin[axis]; };
    for (const std::int32_t* c = order.data(); c != order.data() + order.size();) {
      const std::int32_t* end =
          std::find_if(c, order.data() + order.size(), [&](auto n) { return place(n) != place(*c); });
      layers.push_back({axis, c, end});
      c = end;
    }
  }
  std::vector<LayerRectangles> found;
  found.reserve(layers.size());
  for (const Layer& layer : layers) found.push_back({layer.axis, ReservedList<FaceRectangle>(context, what)});
  context.progress().begin("merging faces", layers.size());
  for_each_index(layers.size(), [&](std::size_t l) {
    if (context.cancelled()) return;
    sweep_layer(voxels, layers[l], faces, found[l].rectangles);
    context.progress().advance(1);
  });
  TRY(context.check());
  for (const LayerRectangles& layer : found) {
    if (layer.rectangles.error()) return tl::unexpected(*layer.rectangles.error());
  }
  return found;
}

}  // namespace isoextract::extract
