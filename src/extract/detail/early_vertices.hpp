// Vertices that a sink takes while the extraction still compares and counts: no later pass reads their samples again.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>
#include <mutex>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "extract/detail/slab_shares.hpp"
#include "extract/mesh_assembly.hpp"
#include "mesh/mesh_sink.hpp"

namespace isoextract::extract {

// Numbers the vertices of slabs that are counted in any order: those of a slab follow those of all slabs before it.
class EarlyVertices {
 public:
  // Without `may_deliver` or a sink, no vertices are early. The references must outlive this object, but for
  // `placement`.
  EarlyVertices(const field::ScalarField& field, const ExtractOptions& options, const Context& context,
                const OutputPlacement& placement, int slabs, bool may_deliver)
      : field_(field),
        options_(options),
        context_(context),
        shape_{.origin = placement.origin(),
               .has_normals = options.smooth_normals,
               .distinct_positions = placement.keeps_vertices_apart()},
        slabs_(may_deliver && options.sink != nullptr ? static_cast<std::size_t>(slabs) : 0) {
    if (!slabs_.empty()) parts_.reserve(static_cast<std::size_t>(usable_threads()));
  }

  // Tells the facts about a slice. NaN samples end the delivery if the mesh needs a later look at them.
  void see(const SliceSides& slice) {
    if (slabs_.empty()) return;
    const std::lock_guard lock(mutex_);
    sides_.add(slice);
    if (sides_.nan > 0 && (options_.smooth_normals || options_.nan == NanPolicy::error)) state_ = State::ended;
  }

  // Tells the sizes of a slab that is counted, and delivers the vertices of all slabs whose first vertex is known now:
  // write(slab, part) fills the first positions and normals of `part`. leave(slab) follows, also for a slab that is not
  // delivered yet. Several threads may call add() at once. As soon as a part of the slabs is counted, it offers their
  // vertices to the sink, with numbers estimated from that part. Leaves out a slab that finds no memory. Fails as the
  // sink does.
  template <class Write, class Leave>
  [[nodiscard]] Result<void> add(int slab, const MeshSizes& sizes, const Write& write, const Leave& leave) {
    const auto ready = slabs_.empty() ? Result<SlabRange>(SlabRange{}) : number(slab, sizes);
    if (!ready || ready->count() == 0) leave(slab);
    if (!ready) return tl::unexpected(ready.error());
    for (int s = ready->begin; s < ready->end; ++s) {
      TRY(deliver(s, write));
      leave(s);
    }
    return {};
  }

  // Frees the memory for parts, after all calls of add(). Returns the number of delivered vertices.
  [[nodiscard]] std::uint64_t finish() {
    parts_.clear();
    return vertices_;
  }

  [[nodiscard]] bool is_delivered(int slab) const { return !slabs_.empty() && at(slab).is_delivered; }

 private:
  struct Slab {
    std::uint64_t first_vertex = 0;
    MeshSizes sizes;
    bool is_counted = false;
    bool is_delivered = false;
  };
  enum class State { waiting, accepted, ended };

  [[nodiscard]] Slab& at(int slab) { return slabs_[static_cast<std::size_t>(slab)]; }
  [[nodiscard]] const Slab& at(int slab) const { return slabs_[static_cast<std::size_t>(slab)]; }

  // Returns the slabs to deliver; the first is this one.
  [[nodiscard]] Result<SlabRange> number(int slab, const MeshSizes& sizes) {
    constexpr int kMostSlabs = 2;  // a thread leaves others to the later pass, in which all threads share them
    const std::lock_guard lock(mutex_);
    at(slab) = {0, sizes, true, false};
    const int count = static_cast<int>(slabs_.size());
    const int begin = next_;
    for (; next_ < count && at(next_).is_counted; ++next_) {
      at(next_).first_vertex = below_.vertices;
      below_.vertices += at(next_).sizes.vertices;
      below_.triangles += at(next_).sizes.triangles;
    }
    if (below_.vertices > std::numeric_limits<std::uint32_t>::max()) state_ = State::ended;
    if (state_ == State::accepted) return SlabRange{begin, std::min(next_, begin + kMostSlabs)};
    if (state_ == State::waiting) TRY(offer());
    return SlabRange{};
  }

  template <class Write>
  [[nodiscard]] Result<void> deliver(int slab, const Write& write) {
    const MeshSizes sizes{at(slab).sizes.vertices, 0};
    if (sizes.vertices == 0) return {};
    std::optional<mesh::Mesh> part;
    try {
      part = take_part(sizes);
      if (!part) return {};
      write(slab, *part);
    } catch (const std::bad_alloc&) {
      return {};
    }
    TRY(deliver_part(*options_.sink, {}, *part, {at(slab).first_vertex, 0}, sizes));
    at(slab).is_delivered = true;
    vertices_ += sizes.vertices;
    const std::lock_guard lock(mutex_);
    if (parts_.size() < parts_.capacity()) parts_.push_back(std::move(*part));
    return {};
  }

  // Returns arrays of at least these sizes, or nullopt if there is no memory. They are those of an earlier slab if they
  // fit: arrays allocated for each slab, in unequal sizes, would fill more and more of the heap.
  [[nodiscard]] std::optional<mesh::Mesh> take_part(const MeshSizes& sizes) {
    std::optional<mesh::Mesh> part(std::in_place);
    if (const std::lock_guard lock(mutex_); !parts_.empty()) {
      part = std::move(parts_.back());
      parts_.pop_back();
    }
    if (part->positions.size() >= sizes.vertices) return part;
    part.emplace();
    const MeshSizes larger{sizes.vertices + sizes.vertices / 8, 0};  // for slabs a little larger than this one
    auto memory = reserve_mesh(field_, larger, options_, context_);
    if (!memory) return std::nullopt;
    part->memory = std::move(*memory);
    allocate_mesh(*part, larger, {}, options_);
    return part;
  }

  // Offers the vertices to the sink once enough slabs are counted. A sink may have to move them if an estimate is
  // wrong, so it does not get very many.
  [[nodiscard]] Result<void> offer() {
    constexpr int kLeastPart = 16;                   // a sixteenth of the slabs
    constexpr std::uint64_t kLeastVertices = 20000;  // fewer take no time
    constexpr std::uint64_t kMostVertices = std::uint64_t{1} << 28U;
    const int count = static_cast<int>(slabs_.size());
    if (next_ <= count / kLeastPart || next_ == count || below_.vertices < kLeastVertices) return {};
    state_ = State::ended;
    const double part = static_cast<double>(next_) / count;
    shape_.vertices = static_cast<std::uint64_t>(static_cast<double>(below_.vertices) / part);
    shape_.triangles = static_cast<std::uint64_t>(static_cast<double>(below_.triangles) / part);
    shape_.may_be_open = !options_.cap && sides_.boundary.inside && sides_.boundary.outside;
    const bool takes = shape_.vertices <= kMostVertices && TRY(options_.sink->begin_early(shape_));
    if (takes) state_ = State::accepted;
    return {};
  }

  const field::ScalarField& field_;
  const ExtractOptions& options_;
  const Context& context_;
  std::mutex mutex_;               // guards the members below, but not slabs that were numbered
  std::vector<mesh::Mesh> parts_;  // arrays for the vertices of a slab, not in use
  mesh::MeshShape shape_;          // an estimate
  std::vector<Slab> slabs_;
  int next_ = 0;     // the first slab that is not numbered
  MeshSizes below_;  // of the slabs before it
  SliceSides sides_;
  State state_ = State::waiting;
  std::atomic<std::uint64_t> vertices_{0};
};

}  // namespace isoextract::extract
