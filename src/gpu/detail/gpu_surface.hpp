// A surface that the GPU draws and the CPU welds: the SurfacePasses (extract/surface_run.hpp) that dense and sparse
// fields share.
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

// The parts of the device's memory, in bytes.
struct DeviceMemoryShares {
  std::uint64_t samples;
  std::uint64_t feedback;
};

// Returns the pipeline that draws a method, or nullopt if the device does not have the method.
[[nodiscard]] std::optional<GpuPipeline> pipeline_of(extract::Method method, const GpuOptions& options);

// The objects that surfaces are drawn with. The pointed-to objects must outlive the surfaces.
struct DrawingTools {
  const gl::GlContext* gl;
  CellPrograms* programs;
  CaptureBuffers* buffers;
  ResidentSamples* resident;  // null if no samples stay on the device
  GpuOptions options;
  DeviceMemoryShares memory;
  int max_texture_size;
};

// The location of the surface; known after classification.
struct SurfaceLocation {
  std::span<const glm::ivec3> origins;  // lowest samples of the sites
  KeyRange inside_keys;
  field::IndexBox region;
  field::IndexBox stored;  // for dense fields: all samples
  bool holes = false;
  bool sparse = false;
};

// Counts and captures portion by portion, as samples and triangles fit on the device, and welds each portion before the
// next one. So count() draws the whole surface, and emit() only writes the result.
class GpuSurface {
 public:
  // All arguments except the boxes must outlive the object. Draws `region` of the samples in `stored`. The method must
  // have a pipeline.
  GpuSurface(const field::ScalarField& field, const extract::ExtractOptions& options, const DrawingTools& tools,
             const field::IndexBox& stored, const field::IndexBox& region, const Context& context);
  virtual ~GpuSurface() = default;

  [[nodiscard]] const extract::OutputPlacement& placement() const { return placement_; }
  [[nodiscard]] bool has_holes() const { return place_.holes; }

  [[nodiscard]] virtual Result<bool> classify(extract::ExtractStats& stats) = 0;
  [[nodiscard]] Result<extract::MeshSizes> count(extract::ExtractStats& stats);
  [[nodiscard]] Result<void> emit(mesh::Mesh& mesh) const;

  [[nodiscard]] virtual std::optional<field::IndexBox> cap_box() const = 0;
  [[nodiscard]] virtual extract::BoundarySides boundary_sides() const = 0;
  [[nodiscard]] virtual bool draws_at_boundary() const = 0;
  [[nodiscard]] virtual bool inside(const glm::ivec3& p) const = 0;
  [[nodiscard]] virtual double value(const glm::ivec3& p) const = 0;
  [[nodiscard]] std::uint32_t edge_vertex(const glm::ivec3& p, int direction) const;

 protected:
  [[nodiscard]] virtual std::int32_t site(const glm::ivec3& p) const = 0;  // the site that owns sample `p`
  [[nodiscard]] virtual std::array<std::int32_t, 8> near(std::size_t site) const = 0;

  // Stores the result of classify(), as its last step.
  void found(const SurfaceLocation& place, std::unique_ptr<FieldSource> source);

  [[nodiscard]] const field::ScalarField& field() const { return field_; }
  [[nodiscard]] const extract::ExtractOptions& options() const { return options_; }
  [[nodiscard]] const DrawingTools& tools() const { return tools_; }
  [[nodiscard]] const Context& context() const { return context_; }
  [[nodiscard]] SourceOptions source_options() const {
    return {options_.smooth_normals, tools_.memory.samples, tools_.max_texture_size, tools_.resident, &context_};
  }

 private:
  [[nodiscard]] Result<gl::CountAndCapture> find_programs() const;
  void set_uniforms(const gl::ShaderProgram& program) const;
  [[nodiscard]] Result<void> draw(const gl::CountAndCapture& pass, CellCapture& capture);
  [[nodiscard]] Result<void> draw_batch(const gl::CountAndCapture& pass, std::span<const std::uint32_t> ready,
                                        CellCapture& capture);
  // Reserves memory before triangles are captured: for them, and for their welded form; `triangles` is the total so
  // far.
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
  extract::OutputPlacement placement_;
  SurfaceLocation place_;
  std::unique_ptr<FieldSource> source_;
  std::uint64_t triangles_ = 0;           // number of triangles captured so far
  Reservation soup_memory_;               // for the captured triangles of the current draw
  Reservation sites_memory_;              // for the data of the weld that grow with the sites
  std::vector<Reservation> weld_memory_;  // for the data of the weld that grow with the triangles, one a draw
  std::optional<SiteWeld> weld_;
  std::atomic<std::uint64_t> hole_cells_{0};  // decided cells left out because they touch NaN samples
};

}  // namespace isoextract::gpu
