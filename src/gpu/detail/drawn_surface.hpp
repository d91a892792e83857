// A surface that is drawn on the device and welded on the host: what a run of extraction (extract/surface_run.hpp) asks
// of one, whatever holds the samples.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "base/context.hpp"
#include "extract/extractor.hpp"
#include "extract/surface_run.hpp"
#include "gpu/detail/cell_programs.hpp"
#include "gpu/detail/field_source.hpp"
#include "gpu/detail/resident_samples.hpp"
#include "gpu/detail/site_weld.hpp"
#include "gpu/gpu_extractor.hpp"

namespace isoextract::gpu {

// How a device's memory is shared out.
struct MemoryShares {
  std::uint64_t samples;
  std::uint64_t feedback;
};

// What draws a method's surfaces; nothing for one that the device does not have.
[[nodiscard]] std::optional<GpuPipeline> pipeline_of(extract::Method method, const GpuOptions& options);

// What surfaces are drawn with. All that is pointed to must outlive them.
struct DrawingTools {
  const gl::GlContext* gl;
  CellPrograms* programs;
  CaptureBuffers* buffers;
  ResidentSamples* resident;  // null where no sample stays on the device
  GpuOptions options;
  MemoryShares memory;
  int max_texture_size;
};

// Where the surface is: what is known once its samples were compared with iso.
struct SurfacePlace {
  std::span<const glm::ivec3> origins;  // of the sites
  KeyRange inside_keys;
  field::IndexBox region;
  field::IndexBox stored;  // every sample of dense fields
  bool holes = false;
  bool sparse = false;
};

// Counting and capturing are done portion by portion, as samples and triangles fit on the device, and every portion is
// welded before the next: so `count` draws all of it, and `emit` only puts together what is there.
class DrawnSurface {
 public:
  // All arguments but the boxes must outlive it; `region` of the samples in `stored` is drawn. There is a pipeline for
  // the method.
  DrawnSurface(const field::ScalarField& field, const extract::ExtractOptions& options, const DrawingTools& tools,
               const field::IndexBox& stored, const field::IndexBox& region, const Context& context);
  virtual ~DrawnSurface() = default;

  [[nodiscard]] const extract::OutputFrame& placement() const { return placement_; }
  [[nodiscard]] bool has_holes() const { return place_.holes; }

  [[nodiscard]] virtual Result<bool> classify(extract::ExtractStats& stats) = 0;
  [[nodiscard]] Result<extract::MeshSizes> count(extract::ExtractStats& stats);
  [[nodiscard]] Result<void> emit(mesh::Mesh& mesh) const;

  [[nodiscard]] virtual std::optional<field::IndexBox> cap_box() const = 0;
  [[nodiscard]] virtual extract::BorderSides border() const = 0;
  [[nodiscard]] virtual bool draws_at_border() const = 0;
  [[nodiscard]] virtual bool inside(const glm::ivec3& p) const = 0;
  [[nodiscard]] virtual double value(const glm::ivec3& p) const = 0;
  [[nodiscard]] std::uint32_t edge_vertex(const glm::ivec3& p, int direction) const;

 protected:
  [[nodiscard]] virtual std::int32_t site(const glm::ivec3& p) const = 0;  // that owns a sample
  [[nodiscard]] virtual std::array<std::int32_t, 8> near(std::size_t site) const = 0;

  // The last step of classify().
  void found(const SurfacePlace& place, std::unique_ptr<FieldSource> source);

  [[nodiscard]] const field::ScalarField& field() const { return field_; }
  [[nodiscard]] const extract::ExtractOptions& options() const { return options_; }
  [[nodiscard]] const DrawingTools& tools() const { return tools_; }
  [[nodiscard]] const Context& context() const { return context_; }
  [[nodiscard]] SourceOptions source_options() const {
    return {options_.smooth_normals, tools_.memory.samples, tools_.max_texture_size, tools_.resident, &context_};
  }

 private:
  [[nodiscard]] Result<gl::CellPass> find_programs() const;
  void set_uniforms(const gl::CellProgram& program) const;
  [[nodiscard]] Result<void> draw(const gl::CellPass& pass, CellCapture& capture);
  [[nodiscard]] Result<void> draw_batch(const gl::CellPass& pass, std::span<const std::uint32_t> ready,
                                        CellCapture& capture);
  // Before triangles are captured: for them, and for what they will be welded
  // to, together with all before.
  [[nodiscard]] Result<void> make_room(std::uint64_t triangles);
  void weld(std::span<const std::uint32_t> sites, const CapturedSoup& soup);
  [[nodiscard]] std::size_t words_a_vertex() const { return options_.smooth_normals ? 7 : 4; }
  [[nodiscard]] unsigned decide(const glm::ivec3& cell);
  [[nodiscard]] bool touches_nan(const glm::ivec3& cell) const;

  const field::ScalarField& field_;
  const extract::ExtractOptions& options_;
  const DrawingTools& tools_;
  const Context& context_;
  GpuPipeline pipeline_;
  const extract::CaseTable& table_;
  extract::OutputFrame placement_;
  SurfacePlace place_;
  std::unique_ptr<FieldSource> source_;
  std::uint64_t triangles_ = 0;           // captured so far
  Reservation soup_memory_;               // for the triangles of a draw, while they are drawn
  Reservation sites_memory_;              // for what the weld has of each site
  std::vector<Reservation> weld_memory_;  // and of each draw
  std::optional<SiteWeld> weld_;
  std::atomic<std::uint64_t> hole_cells_{0};  // that came to be decided
};

}  // namespace isoextract::gpu
