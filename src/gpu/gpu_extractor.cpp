#include "gpu/gpu_extractor.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include <fmt/format.h>

#include "extract/border_cap.hpp"
#include "extract/dense_input.hpp"
#include "gpu/detail/cell_programs.hpp"
#include "gpu/detail/dense_sites.hpp"
#include "gpu/detail/dense_source.hpp"
#include "gpu/detail/site_weld.hpp"
#include "gpu/detail/sparse_source.hpp"
#include "mesh/vertex_fans.hpp"

namespace isoextract::gpu {
namespace {

constexpr std::uint64_t kMiB = 1 << 20;

// How a device's memory is shared out.
struct MemoryShares {
  std::uint64_t samples;
  std::uint64_t feedback;
};

MemoryShares share_memory(const GpuOptions& options, const gl::GpuDevice& device) {
  // Drivers limit one texture, some to a quarter of the memory.
  const std::uint64_t all = options.memory_bytes.value_or(device.memory_bytes ? *device.memory_bytes / 4 : 1024 * kMiB);
  const std::uint64_t feedback = std::min(all / 4, 256 * kMiB);
  return {all - feedback, feedback};
}

// What drawing and welding ask of a field, dense or sparse. Samples are given by their index in the field.
struct SurfaceSites {
  std::span<const glm::ivec3> origins;
  NearSites near;
  std::function<std::int32_t(const glm::ivec3&)> site;  // that owns a sample
  std::function<bool(const glm::ivec3&)> inside;
  std::function<double(const glm::ivec3&)> value;
  KeyRange inside_keys;
  field::IndexBox region;
  field::IndexBox stored;  // every sample of the field
  bool holes = false;
  bool sparse = false;
  bool can_cap = true;
};

class GpuExtractor final : public extract::Extractor {
 public:
  GpuExtractor(std::unique_ptr<gl::GlContext> context, const GpuOptions& options)
      : context_(std::move(context)), options_(options), memory_(share_memory(options, context_->device())) {
    glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &max_texture_size_);
  }

  GpuExtractor(const GpuExtractor&) = delete;
  GpuExtractor& operator=(const GpuExtractor&) = delete;
  ~GpuExtractor() override { context_->make_current(); }  // for what members have on the device

  [[nodiscard]] std::string_view name() const override { return "gpu"; }
  [[nodiscard]] std::string device() const override { return gl::describe(context_->device()); }

  [[nodiscard]] Result<extract::Extraction> extract(const field::ScalarField& field,
                                                    const extract::ExtractOptions& options) override {
    // Another extractor may have come since.
    if (auto current = context_->make_current(); !current) return tl::unexpected(current.error());
    return extract::extract_guarded(field, options,
                                    [&](const auto& samples) { return extract_from(field, samples, options); });
  }

 private:
  Result<extract::Extraction> extract_from(const field::ScalarField& field, const field::DenseSamples& samples,
                                           const extract::ExtractOptions& options) {
    const auto region = extract::dense_region(field, samples, options);
    if (!region) return tl::unexpected(region.error());
    return visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) {
      return extract_dense<T>(field, samples, *region, options);
    });
  }

  template <class T>
  Result<extract::Extraction> extract_dense(const field::ScalarField& field, const field::DenseSamples& samples,
                                            const field::IndexBox& region, const extract::ExtractOptions& options) {
    const extract::DenseView<T> whole = extract::dense_view<T>(samples);
    const extract::DenseView<T> view = extract::part_of(whole, region);
    const extract::OutputFrame placement(options.output_from_index, {glm::ivec3(0), samples.dims - 1}, field.kind,
                                         field.scale);
    extract::Extraction result;
    result.mesh.origin = placement.origin();
    result.stats.brick = "8x8x8 cells";
    if (auto fits = extract::check_placement(field, placement); !fits) return tl::unexpected(fits.error());
    extract::DenseMasks masks(view.dims);
    const auto threshold = extract::classify_dense(field, view, region.min, options, masks, result.stats);
    if (!threshold) return tl::unexpected(threshold.error());
    if (!*threshold) return result;
    const Stopwatch watch;
    const DenseSites bricks(masks, region.min);
    result.stats.bricks = bricks.bricks();
    result.stats.bricks_visited = bricks.origins().size();
    result.stats.classify += watch.elapsed();

    SurfaceSites sites;
    sites.origins = bricks.origins();
    sites.near = [&](std::size_t s) { return bricks.near(s); };
    sites.site = [&](const glm::ivec3& p) { return bricks.site(p); };
    sites.inside = [&](const glm::ivec3& p) { return masks.inside(p - region.min); };
    sites.value = [&](const glm::ivec3& p) { return field.scale(static_cast<double>(whole.row(p.y, p.z)[p.x])); };
    sites.inside_keys = inside_keys(**threshold);
    sites.region = region;
    sites.stored = {glm::ivec3(0), samples.dims - 1};
    sites.holes = result.stats.nan_samples != 0 && options.nan == extract::NanPolicy::hole;
    auto source = DenseSource::make(*context_, samples, sites.origins, region,
                                    {options.smooth_normals, memory_.samples, max_texture_size_});
    if (!source) return tl::unexpected(source.error());
    if (auto done = draw(field, options, placement, sites, *source, result); !done) return tl::unexpected(done.error());
    return result;
  }

  Result<extract::Extraction> extract_from(const field::ScalarField& field, const field::SparseSamples& samples,
                                           const extract::ExtractOptions& options) {
    const auto region = extract::sparse_region(field, samples, options);
    if (!region) return tl::unexpected(region.error());
    extract::Extraction result;
    result.stats.brick = "8x8x8 voxels";
    if (region->empty()) return result;
    const extract::OutputFrame placement(options.output_from_index, extract::stored_box(samples), field.kind,
                                         field.scale);
    result.mesh.origin = placement.origin();
    if (auto fits = extract::check_placement(field, placement); !fits) return tl::unexpected(fits.error());
    extract::SparseSites leaves(field, samples, *region, options);
    if (auto found = leaves.find(result.stats); !found) return tl::unexpected(found.error());
    const auto keys = visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) -> std::optional<KeyRange> {
      const auto threshold =
          extract::find_inside_threshold<T>(extract::InsideRule{field.kind, options.iso}, field.scale);
      if (!threshold) return std::nullopt;
      return inside_keys(*threshold);
    });
    if (!keys) return result;

    SurfaceSites sites;
    sites.origins = leaves.origins();
    sites.near = [&](std::size_t s) { return leaves.near(s); };
    sites.site = [&](const glm::ivec3& p) { return leaves.site(field::block_origin(p)); };
    sites.inside = [&](const glm::ivec3& p) { return leaves.inside(p); };
    sites.value = [&](const glm::ivec3& p) { return leaves.value(p); };
    sites.inside_keys = *keys;
    sites.region = *region;
    sites.holes = leaves.has_holes();
    sites.sparse = true;
    sites.can_cap = options.region.has_value();
    auto source =
        SparseSource::make(*context_, samples, leaves, {options.smooth_normals, memory_.samples, max_texture_size_});
    if (!source) return tl::unexpected(source.error());
    if (auto done = draw(field, options, placement, sites, *source, result); !done) return tl::unexpected(done.error());
    return result;
  }

  static CellProgramKind with_normals(CellProgramKind kind, bool wanted) {
    kind.normals = wanted ? CapturedNormals::gradient : CapturedNormals::none;
    return kind;
  }

  [[nodiscard]] GpuPipeline pipeline(extract::Method method) const {
    if (method == extract::Method::mt) return GpuPipeline::mt_geometry;
    return options_.tessellation ? GpuPipeline::mc_tessellation : GpuPipeline::mc_points;
  }

  Result<void> draw(const field::ScalarField& field, const extract::ExtractOptions& options,
                    const extract::OutputFrame& placement, const SurfaceSites& sites, FieldSource& source,
                    extract::Extraction& result) {
    CellProgramKind kind;
    kind.pipeline = pipeline(options.method);
    kind.sample_define = sample_format(field.type()).define;
    kind.sparse = sites.sparse;
    kind.scaled = !field.scale.is_identity();
    kind.holes = sites.holes;
    kind.swizzle = options_.swizzle;
    const Stopwatch compiling;
    const auto capturing = programs_.find(*context_, with_normals(kind, options.smooth_normals));
    if (!capturing) return tl::unexpected(capturing.error());
    kind.counting = true;
    const auto counting = programs_.find(*context_, kind);
    if (!counting) return tl::unexpected(counting.error());
    extract::DeviceStats& device = result.stats.device.emplace();
    device.compile = compiling.elapsed();
    const gl::CellPass pass{*counting, *capturing};
    for (const gl::CellProgram* program : pass.programs()) set_uniforms(*program, field, options, placement, sites);

    const extract::CaseTable& table = extract::case_table(options.method);
    const extract::InsideRule rule{field.kind, options.iso};
    std::atomic<std::uint64_t> hole_cells{0};
    const auto decide = [&](const glm::ivec3& cell) -> unsigned {
      if (sites.holes && touches_nan(sites, cell)) {
        hole_cells.fetch_add(1, std::memory_order_relaxed);
        return table.variants[0];
      }
      unsigned cell_case = 0;
      for (int c = 0; c < 8; ++c) cell_case |= (sites.inside(cell + extract::direction_step(c)) ? 1U : 0U) << c;
      return extract::cell_variant(table, cell_case, rule,
                                   [&](int c) { return sites.value(cell + extract::direction_step(c)); });
    };
    SiteWeld weld(table, sites.origins, sites.near, decide);
    CellCapture capture(*context_, kind.pipeline, options.smooth_normals ? 7 : 4, memory_.feedback);
    if (options.progress != nullptr) options.progress->begin("drawing cells", sites.origins.size());
    while (true) {
      const auto ready = source.advance();
      if (!ready) return tl::unexpected(ready.error());
      if (ready->empty()) break;
      if (auto drawn = draw_batch(field, pass, *ready, sites, source, capture, weld, options); !drawn) return drawn;
    }
    if (auto quiet = check_messages(); !quiet) return quiet;
    result.stats.hole_cells = hole_cells.load();

    const auto sizes = weld.number();
    if (!sizes) return tl::unexpected(sizes.error());
    if (auto fits = extract::check_mesh_size(field, *sizes, options); !fits) return fits;
    const Stopwatch watch;
    if (auto made = make_mesh(field, options, placement, sites, weld, *sizes, result.mesh); !made) return made;
    result.stats.emit = watch.elapsed();
    tell(capture, weld, source.uploads(), result.stats);
    return {};
  }

  Result<void> draw_batch(const field::ScalarField& field, const gl::CellPass& pass,
                          std::span<const std::uint32_t> ready, const SurfaceSites& sites, FieldSource& source,
                          CellCapture& capture, SiteWeld& weld, const extract::ExtractOptions& options) {
    std::vector<glm::ivec3> origins(ready.size());
    for (std::size_t s = 0; s < ready.size(); ++s) origins[s] = sites.origins[ready[s]];
    return capture.draw(
        pass, origins, [&](std::size_t first, std::size_t count) { source.bind(pass, ready.subspan(first, count)); },
        [&](std::size_t first, std::size_t count, const CapturedSoup& soup) {
          weld.add(ready.subspan(first, count), soup);
          if (options.progress != nullptr) options.progress->advance(count);
        },
        [&](std::uint64_t triangles) {
          return extract::check_mesh_size(field, {0, triangles}, options);
        });
  }

  static void set_uniforms(const gl::CellProgram& program, const field::ScalarField& field,
                           const extract::ExtractOptions& options, const extract::OutputFrame& placement,
                           const SurfaceSites& sites) {
    program.set("inside_from", sites.inside_keys.from);
    program.set("inside_to", sites.inside_keys.to);
    program.set("first_cell", sites.region.min);
    program.set("last_cell", sites.region.max - 1);
    program.set("last_sample", sites.stored.max);
    program.set("iso_value", options.iso);
    program.set("edge_margin", placement.margin());
    program.set("value_slope", field.scale.slope);
    program.set("value_intercept", field.scale.intercept);
    const field::Affine& local = placement.local_from_index();
    program.set("local_x", local.linear[0]);
    program.set("local_y", local.linear[1]);
    program.set("local_z", local.linear[2]);
    program.set("local_offset", local.offset);
    const glm::dmat3 outward = placement.outward_covectors();
    program.set("covector_x", outward[0]);
    program.set("covector_y", outward[1]);
    program.set("covector_z", outward[2]);
  }

  Result<void> make_mesh(const field::ScalarField& field, const extract::ExtractOptions& options,
                         const extract::OutputFrame& placement, const SurfaceSites& sites, const SiteWeld& weld,
                         const extract::MeshSizes& sizes, mesh::Mesh& mesh) {
    extract::BorderCap cap;
    if (options.cap && sites.can_cap) {
      if (auto fits = extract::check_cap_size(field, sites.region, options); !fits) return fits;
      const extract::InsideRule rule{field.kind, options.iso};
      cap = extract::make_border_cap(
          sites.region, options.method, static_cast<std::uint32_t>(sizes.vertices), sites.inside,
          [&](const glm::ivec3& p, int direction) {
            const auto site = static_cast<std::size_t>(sites.site(p));
            return weld.vertex_at(site, direction, field::block_offset(p - sites.origins[site]));
          },
          [&](const glm::ivec3& p) { return rule.depth(sites.value(p)); },
          [&](const glm::ivec3& p) { return sites.holes && std::isnan(sites.value(p)); });
      if (auto fits = extract::check_mesh_size(field, extract::with_cap(sizes, cap), options); !fits) return fits;
    }
    extract::allocate_mesh(mesh, sizes, cap, options);
    weld.write(mesh, placement.mirrored());
    extract::append_cap(mesh, sizes, cap, sites.region, glm::ivec3(0), placement);
    return sites.holes
               ? mesh::make_one_vertex_a_fan(mesh, field.source, Context(MemoryBudget(options.limits.memory_bytes)))
               : Result<void>();
  }

  static bool touches_nan(const SurfaceSites& sites, const glm::ivec3& cell) {
    for (int c = 0; c < 8; ++c) {
      if (std::isnan(sites.value(cell + extract::direction_step(c)))) return true;
    }
    return false;
  }

  void tell(const CellCapture& capture, const SiteWeld& weld, const UploadFigures& uploads,
            extract::ExtractStats& stats) const {
    extract::DeviceStats& device = *stats.device;
    device.bytes_uploaded = uploads.bytes;
    device.samples_uploaded = uploads.samples;
    device.bytes_captured = capture.captured_bytes();
    device.cells_decided = weld.decided_cells() - stats.hole_cells;  // those came to be left out
    device.upload = uploads.time;
    device.capture = capture.times().capture;
    device.read_back = capture.times().read_back;
    device.weld = weld.time();
    stats.count = capture.times().count;
    for (const StageTime& part : {device.capture, device.read_back, device.weld}) stats.emit += part;
  }

  [[nodiscard]] Result<void> check_messages() const {
    if (!options_.debug || context_->debug_messages().empty()) return {};
    return fail(ErrorKind::unavailable,
                fmt::format("{}: the driver complains: {}", device(), context_->debug_messages().front()));
  }

  std::unique_ptr<gl::GlContext> context_;  // first, so that it goes last
  GpuOptions options_;
  MemoryShares memory_;
  GLint max_texture_size_ = 0;
  CellPrograms programs_;
};

}  // namespace

Result<GpuExtractorAndDevice> make_gpu_extractor(const GpuOptions& options) {
  if (options.memory_bytes && *options.memory_bytes < kMiB) {
    return fail(ErrorKind::usage,
                fmt::format("--gpu-memory: expected 1 MiB or more, found {}", format_byte_size(*options.memory_bytes)),
                "for example --gpu-memory 256M");
  }
  auto context = gl::GlContext::open({options.device, options.debug});
  if (!context) return tl::unexpected(context.error());
  gl::GpuDevice device = (*context)->device();
  return GpuExtractorAndDevice{std::make_unique<GpuExtractor>(std::move(*context), options), std::move(device)};
}

}  // namespace isoextract::gpu
