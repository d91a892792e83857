#include "gpu/gpu_extractor.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "extract/boundary_cap.hpp"
#include "extract/dense_input.hpp"
#include "gpu/detail/dense_sites.hpp"
#include "gpu/detail/dense_source.hpp"
#include "gpu/detail/gpu_surface.hpp"
#include "gpu/detail/sparse_source.hpp"

namespace isoextract::gpu {
namespace {

constexpr std::uint64_t kMiB = 1 << 20;

DeviceMemoryShares share_memory(const GpuOptions& options, const gl::GpuDevice& device) {
  // Drivers limit the size of one texture, some to a quarter of the memory.
  const std::uint64_t all = options.memory_bytes.value_or(device.memory_bytes ? *device.memory_bytes / 4 : 1024 * kMiB);
  const std::uint64_t feedback = std::min(all / 4, 256 * kMiB);
  return {all - feedback, feedback};
}

template <class T>
class DenseSurface final : public GpuSurface {
 public:
  DenseSurface(const field::ScalarField& field, const field::DenseSamples& samples, const field::IndexBox& region,
               extract::DenseMasks masks, const extract::ExtractOptions& options, const DrawingTools& tools,
               const Context& context)
      : GpuSurface(field, options, tools, {glm::ivec3(0), samples.dims - 1}, region, context),
        samples_(samples),
        whole_(extract::dense_view<T>(samples)),
        region_(region),
        masks_(std::move(masks)) {}

  [[nodiscard]] Result<bool> classify(extract::ExtractStats& stats) override {
    stats.brick = "8x8x8 cells";
    const extract::DenseView<T> view = extract::part_of(whole_, region_);
    const auto threshold =
        TRY(extract::classify_dense(field(), view, region_.min, options(), masks_, stats, context()));
    if (!threshold) return false;
    bricks_memory_ = TRY(
        context().reserve(DenseSites::bytes(view.dims), fmt::format("{}: the table of its bricks", field().source)));
    const Stopwatch watch;
    bricks_.emplace(masks_, region_.min);
    stats.bricks = bricks_->bricks();
    stats.bricks_visited = bricks_->origins().size();
    stats.classify += watch.elapsed();
    auto source = TRY(DenseSource::make(*tools().gl, samples_, bricks_->origins(), region_, source_options()));
    SurfaceLocation place;
    place.origins = bricks_->origins();
    place.inside_keys = inside_keys(*threshold);
    place.region = region_;
    place.stored = {glm::ivec3(0), samples_.dims - 1};
    place.holes = stats.nan_samples != 0 && options().nan == extract::NanPolicy::hole;
    found(place, std::make_unique<DenseSource>(std::move(source)));
    return true;
  }

  [[nodiscard]] std::optional<field::IndexBox> cap_box() const override { return region_; }
  [[nodiscard]] extract::BoundarySides boundary_sides() const override { return masks_.boundary_sides(); }
  [[nodiscard]] bool draws_at_boundary() const override {
    return extract::draws_at_boundary(
        region_, [this](const glm::ivec3& p) { return inside(p); },
        [this](const glm::ivec3& p) { return std::isnan(value(p)); });
  }
  [[nodiscard]] bool inside(const glm::ivec3& p) const override { return masks_.inside(p - region_.min); }
  [[nodiscard]] double value(const glm::ivec3& p) const override {
    return field().scale(static_cast<double>(whole_.row(p.y, p.z)[p.x]));
  }

 private:
  [[nodiscard]] std::int32_t site(const glm::ivec3& p) const override { return bricks_->site(p); }
  [[nodiscard]] std::array<std::int32_t, 8> near(std::size_t site) const override { return bricks_->near(site); }

  const field::DenseSamples& samples_;
  extract::DenseView<T> whole_;
  field::IndexBox region_;
  extract::DenseMasks masks_;
  Reservation bricks_memory_;
  std::optional<DenseSites> bricks_;
};

class SparseSurface final : public GpuSurface {
 public:
  SparseSurface(const field::ScalarField& field, const field::SparseSamples& samples, const field::IndexBox& region,
                const extract::ExtractOptions& options, const DrawingTools& tools, const Context& context)
      : GpuSurface(field, options, tools, extract::stored_box(samples), region, context),
        samples_(samples),
        region_(region),
        leaves_(field, samples, region, options, context) {}

  [[nodiscard]] Result<bool> classify(extract::ExtractStats& stats) override {
    TRY(leaves_.find(stats));
    const auto keys = visit_sample_type(samples_.type, [&]<class T>(std::type_identity<T>) -> std::optional<KeyRange> {
      const extract::InsideRule rule{field().kind, options().iso};
      const auto threshold = extract::find_inside_threshold<T>(rule, field().scale);
      return threshold ? std::optional(inside_keys(*threshold)) : std::nullopt;
    });
    if (!keys) return false;
    if (tools().resident != nullptr) tools().resident->drop();  // the atlas needs the memory of the resident samples
    auto source = TRY(SparseSource::make(*tools().gl, samples_, leaves_, source_options()));
    SurfaceLocation place;
    place.origins = leaves_.origins();
    place.inside_keys = *keys;
    place.region = region_;
    place.holes = leaves_.has_holes();
    place.sparse = true;
    found(place, std::make_unique<SparseSource>(std::move(source)));
    return true;
  }

  [[nodiscard]] std::optional<field::IndexBox> cap_box() const override {
    return extract::sparse_cap_box(region_, options());
  }
  [[nodiscard]] extract::BoundarySides boundary_sides() const override { return leaves_.boundary_sides(); }
  [[nodiscard]] bool draws_at_boundary() const override { return leaves_.draws_at_boundary(); }
  [[nodiscard]] bool inside(const glm::ivec3& p) const override { return leaves_.inside(p); }
  [[nodiscard]] double value(const glm::ivec3& p) const override { return leaves_.value(p); }

 private:
  [[nodiscard]] std::int32_t site(const glm::ivec3& p) const override { return leaves_.site(field::block_origin(p)); }
  [[nodiscard]] std::array<std::int32_t, 8> near(std::size_t site) const override {
    return leaves_.upper_neighbors(site);
  }

  const field::SparseSamples& samples_;
  field::IndexBox region_;
  extract::SparseSites leaves_;
};

class GpuExtractor final : public extract::Extractor {
 public:
  GpuExtractor(std::unique_ptr<gl::GlContext> context, const GpuOptions& options)
      : gl_(std::move(context)), buffers_(CaptureBuffers::make()), tools_{gl_.get(),
                                                                          &programs_,
                                                                          &buffers_,
                                                                          options.keep_samples ? &resident_ : nullptr,
                                                                          options,
                                                                          share_memory(options, gl_->device()),
                                                                          0} {
    glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &tools_.max_texture_size);
  }

  GpuExtractor(const GpuExtractor&) = delete;
  GpuExtractor& operator=(const GpuExtractor&) = delete;
  ~GpuExtractor() override { gl_->make_current(); }  // members free device memory

  [[nodiscard]] std::string_view name() const override { return "gpu"; }
  [[nodiscard]] std::string device() const override { return gl::describe(gl_->device()); }
  [[nodiscard]] bool has(extract::Method method) const override {
    return pipeline_of(method, tools_.options).has_value();
  }

 private:
  [[nodiscard]] Result<extract::Extraction> run(const field::ScalarField& field, const extract::ExtractOptions& options,
                                                const Context& context) override {
    // Another extractor may have made its context current.
    TRY(gl_->make_current());
    return std::visit([&](const auto& samples) { return extract_from(field, samples, options, context); },
                      field.samples);
  }

  Result<extract::Extraction> extract_from(const field::ScalarField& field, const field::DenseSamples& samples,
                                           const extract::ExtractOptions& options, const Context& context) {
    const auto region = TRY(extract::dense_region(field, samples, options));
    auto masks = TRY(extract::make_masks(field, glm::ivec3(region.dims()), context));
    return visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) {
      DenseSurface<T> surface(field, samples, region, std::move(masks), options, tools_, context);
      return extract::extract_surface(field, options, surface, context);
    });
  }

  Result<extract::Extraction> extract_from(const field::ScalarField& field, const field::SparseSamples& samples,
                                           const extract::ExtractOptions& options, const Context& context) {
    const auto region = TRY(extract::sparse_region(field, samples, options));
    if (region.empty()) return extract::empty_sparse_extraction();
    SparseSurface surface(field, samples, region, options, tools_, context);
    return extract::extract_surface(field, options, surface, context);
  }

  std::unique_ptr<gl::GlContext> gl_;  // first member, so that it is destroyed last
  CellPrograms programs_;
  CaptureBuffers buffers_;
  ResidentSamples resident_;
  DrawingTools tools_;
};

}  // namespace

Result<GpuExtractorAndDevice> make_gpu_extractor(const GpuOptions& options) {
  if (options.memory_bytes && *options.memory_bytes < kMiB) {
    return fail(ErrorCode::usage,
                fmt::format("the GPU memory limit is too small: expected 1 MiB or more, found {}",
                            format_byte_size(*options.memory_bytes)),
                {{Remedy::raise, Setting::gpu_memory}, {Remedy::use, Setting::cpu_backend}});
  }
  auto context = TRY(gl::GlContext::open({options.device, options.debug}));
  gl::GpuDevice device = context->device();
  return GpuExtractorAndDevice{std::make_unique<GpuExtractor>(std::move(context), options), std::move(device)};
}

}  // namespace isoextract::gpu
