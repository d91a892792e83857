// Assembles the parts of the GPU extractor by hand, so that tests can choose what users cannot: the sizes of windows,
// atlases, textures and captures, and flat normals.
#pragma once

#include <epoxy/gl.h>

#include <functional>
#include <memory>
#include <set>
#include <stdexcept>
#include <utility>

#include <gtest/gtest.h>

#include "extract/asymptotic_decider.hpp"
#include "extract/dense_input.hpp"
#include "extract/sparse_sites.hpp"
#include "gpu/detail/cell_programs.hpp"
#include "gpu/detail/dense_sites.hpp"
#include "gpu/detail/dense_source.hpp"
#include "gpu/detail/site_weld.hpp"
#include "gpu/detail/sparse_source.hpp"

namespace isoextract::test {

inline constexpr std::uint64_t kFeedback = std::uint64_t{1} << 24;  // more than any surface of these tests needs

// A context and its programs, opened at first use and destroyed before the program ends.
class OwnContext final : public testing::Environment {
 public:
  const gl::GlContext& context() {
    if (context_ == nullptr) {
      auto opened = gl::GlContext::open({{}, true});
      if (!opened) throw std::runtime_error(opened.error().message);
      context_ = std::move(*opened);
      programs_ = std::make_unique<gpu::CellPrograms>();
    }
    if (const auto current = context_->make_current(); !current) throw std::runtime_error(current.error().message);
    return *context_;
  }
  gpu::CellPrograms& programs() { return *programs_; }
  void TearDown() override {
    if (context_ != nullptr) context_->make_current();
    programs_.reset();
    context_.reset();
  }

 private:
  std::unique_ptr<gl::GlContext> context_;
  std::unique_ptr<gpu::CellPrograms> programs_;
};

inline auto* const kOwnContext = static_cast<OwnContext*>(testing::AddGlobalTestEnvironment(new OwnContext));

inline int max_texture_size() {
  (void)kOwnContext->context();
  GLint size = 0;
  glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &size);
  return size;
}

// The data to draw, independent of the kind of samples.
struct CapturedSites {
  const field::ScalarField* field = nullptr;
  extract::ExtractOptions options;
  std::span<const glm::ivec3> origins;
  gpu::NearSites near;
  std::function<bool(const glm::ivec3&)> inside;
  std::function<double(const glm::ivec3&)> value;
  gpu::KeyRange keys{};
  field::IndexBox region;
  field::IndexBox stored;  // for placement
  gpu::CellProgramKind kind;
};

// Draws all sites in the portions that their source makes ready.
inline Result<void> capture_sites(
    const CapturedSites& sites, gpu::FieldSource& source, std::uint64_t feedback_bytes,
    const std::function<void(std::span<const std::uint32_t>, const gpu::CapturedSoup&)>& take) {
  const gl::GlContext& context = kOwnContext->context();
  gpu::CellProgramKind kind = sites.kind;
  const auto capturing = TRY(kOwnContext->programs().find(context, kind));
  kind.counting = true;
  kind.normals = gpu::CapturedNormals::none;
  const auto counting = TRY(kOwnContext->programs().find(context, kind));
  const extract::OutputPlacement placement(sites.options.output_from_index, sites.stored, sites.field->kind,
                                           sites.field->scale);
  const glm::dmat3 outward = placement.outward_covectors();
  const field::Affine& local = placement.local_from_index();
  for (const gl::ShaderProgram* program : {counting, capturing}) {
    program->set("inside_from", sites.keys.from);
    program->set("inside_to", sites.keys.to);
    program->set("first_cell", sites.region.min);
    program->set("last_cell", sites.region.max - 1);
    program->set("last_sample", sites.stored.max);
    program->set("iso_value", sites.options.iso);
    program->set("edge_margin", placement.margin());
    program->set("local_x", local.linear[0]);
    program->set("local_y", local.linear[1]);
    program->set("local_z", local.linear[2]);
    program->set("local_offset", local.offset);
    program->set("covector_x", outward[0]);
    program->set("covector_y", outward[1]);
    program->set("covector_z", outward[2]);
  }
  const std::size_t words = sites.kind.normals == gpu::CapturedNormals::none ? 4 : 7;
  const std::size_t known_messages = context.debug_messages().size();
  gpu::CaptureBuffers buffers = gpu::CaptureBuffers::make();
  gpu::CellCapture capture(context, buffers, sites.kind.pipeline, words, feedback_bytes);
  while (true) {
    const auto ready = TRY(source.advance());
    if (ready.empty()) break;
    std::vector<glm::ivec3> origins;
    for (const std::uint32_t site : ready) origins.push_back(sites.origins[site]);
    const auto drawn = capture.draw(
        {counting, capturing}, origins,
        [&](std::size_t first, std::size_t count) {
          source.bind({counting, capturing}, ready.subspan(first, count));
        },
        [&](std::size_t first, std::size_t count, const gpu::CapturedSoup& soup) {
          take(ready.subspan(first, count), soup);
        },
        [](std::uint64_t) { return Result<void>(); });
    if (!drawn) return drawn;
  }
  for (std::size_t m = known_messages; m < context.debug_messages().size(); ++m) {
    ADD_FAILURE() << context.debug_messages()[m];
  }
  return {};
}

// Returns the mesh, with edge keys.
inline mesh::Mesh captured_mesh(const CapturedSites& sites, gpu::FieldSource& source, std::uint64_t feedback_bytes) {
  const extract::CaseTable& table = extract::case_table(sites.options.method);
  const extract::InsideRule rule{sites.field->kind, sites.options.iso};
  gpu::SiteWeld weld(table, sites.origins, sites.near, [&](const glm::ivec3& cell) {
    unsigned cell_case = 0;
    for (int c = 0; c < 8; ++c) cell_case |= (sites.inside(cell + extract::direction_step(c)) ? 1U : 0U) << c;
    return extract::cell_variant(table, cell_case, rule,
                                 [&](int c) { return sites.value(cell + extract::direction_step(c)); });
  });
  const auto drawn = capture_sites(sites, source, feedback_bytes,
                                   [&](auto batch, const gpu::CapturedSoup& soup) { weld.add(batch, soup); });
  if (!drawn) {
    ADD_FAILURE() << drawn.error().message;
    return {};
  }
  const auto sizes = weld.number();
  if (!sizes) {
    ADD_FAILURE() << sizes.error().message;
    return {};
  }
  extract::ExtractOptions options = sites.options;
  options.edge_keys = true;
  mesh::Mesh mesh;
  mesh.name = sites.field->name;
  extract::allocate_mesh(mesh, *sizes, {}, options);
  weld.write(mesh, false);
  return mesh;
}

inline gpu::GpuPipeline usual_pipeline(extract::Method method) {
  return method == extract::Method::mt ? gpu::GpuPipeline::mt_geometry : gpu::GpuPipeline::mc_tessellation;
}

// Dense float samples and their bricks.
class DenseSurface {
 public:
  DenseSurface(const field::ScalarField& field, const extract::ExtractOptions& options)
      : samples_(std::get<field::DenseSamples>(field.samples)),
        view_(extract::dense_view<float>(samples_)),
        masks_(samples_.dims),
        whole_{glm::ivec3(0), samples_.dims - 1} {
    extract::ExtractStats stats;
    const auto threshold = extract::classify_dense(field, view_, glm::ivec3(0), options, masks_, stats, Context());
    bricks_ = std::make_unique<gpu::DenseSites>(masks_, glm::ivec3(0));
    sites_.field = &field;
    sites_.options = options;
    sites_.origins = bricks_->origins();
    sites_.near = [this](std::size_t site) { return bricks_->near(site); };
    sites_.inside = [this](const glm::ivec3& p) { return masks_.inside(p); };
    sites_.value = [this](const glm::ivec3& p) { return static_cast<double>(view_.row(p.y, p.z)[p.x]); };
    sites_.keys = gpu::inside_keys(threshold.value().value());
    sites_.region = sites_.stored = whole_;
    sites_.kind.pipeline = usual_pipeline(options.method);
    sites_.kind.sample_define = "SAMPLE_F32";
    sites_.kind.normals = options.smooth_normals ? gpu::CapturedNormals::gradient : gpu::CapturedNormals::none;
  }

  [[nodiscard]] CapturedSites& sites() { return sites_; }

  [[nodiscard]] Result<gpu::DenseSource> source(std::uint64_t bytes, int max_texture) const {
    return gpu::DenseSource::make(kOwnContext->context(), samples_, sites_.origins, whole_,
                                  {sites_.options.smooth_normals, bytes, max_texture});
  }

 private:
  const field::DenseSamples& samples_;
  extract::DenseView<float> view_;
  extract::DenseMasks masks_;
  field::IndexBox whole_;
  std::unique_ptr<gpu::DenseSites> bricks_;
  CapturedSites sites_;
};

// Sparse float samples and their leaves.
class SparseSurface {
 public:
  SparseSurface(const field::ScalarField& field, const extract::ExtractOptions& options)
      : samples_(std::get<field::SparseSamples>(field.samples)),
        options_(options),
        region_(extract::sparse_region(field, samples_, options).value()),
        leaves_(field, samples_, region_, options_, Context()) {
    extract::ExtractStats stats;
    EXPECT_TRUE(leaves_.find(stats));
    sites_.field = &field;
    sites_.options = options;
    sites_.origins = leaves_.origins();
    sites_.near = [this](std::size_t site) { return leaves_.upper_neighbors(site); };
    sites_.inside = [this](const glm::ivec3& p) { return leaves_.inside(p); };
    sites_.value = [this](const glm::ivec3& p) { return leaves_.value(p); };
    sites_.keys =
        gpu::inside_keys(extract::find_inside_threshold<float>({field.kind, options.iso}, field.scale).value());
    sites_.region = region_;
    sites_.stored = extract::stored_box(samples_);
    sites_.kind.pipeline = usual_pipeline(options.method);
    sites_.kind.sample_define = "SAMPLE_F32";
    sites_.kind.sparse = true;
    sites_.kind.normals = options.smooth_normals ? gpu::CapturedNormals::gradient : gpu::CapturedNormals::none;
  }

  [[nodiscard]] CapturedSites& sites() { return sites_; }

  [[nodiscard]] Result<gpu::SparseSource> source(std::uint64_t bytes, int max_texture) const {
    return gpu::SparseSource::make(kOwnContext->context(), samples_, leaves_,
                                   {options_.smooth_normals, bytes, max_texture});
  }

  // Returns the number of stored leaves that the cells of sites need.
  [[nodiscard]] std::size_t needed_leaves() const {
    std::set<std::int32_t> needed;
    for (const glm::ivec3& origin : leaves_.origins()) {
      const int lowest = options_.smooth_normals ? -1 : 0;
      for (int z = lowest; z <= 1; ++z) {
        for (int y = lowest; y <= 1; ++y) {
          for (int x = lowest; x <= 1; ++x) needed.insert(leaves_.lookup().block(origin + 8 * glm::ivec3(x, y, z)));
        }
      }
    }
    needed.erase(-1);
    return needed.size();
  }

 private:
  const field::SparseSamples& samples_;
  extract::ExtractOptions options_;
  field::IndexBox region_;
  extract::SparseSites leaves_;
  CapturedSites sites_;
};

}  // namespace isoextract::test
