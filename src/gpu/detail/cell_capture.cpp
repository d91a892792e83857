#include "gpu/detail/cell_capture.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace isoextract::gpu {
namespace {

constexpr int kCellsPerSite = 512;
constexpr std::size_t kMaxSites = 65536;    // limit of a draw: a key has 16 bits for the site
constexpr std::size_t kTexelsPerSite = 27;  // in the largest texture buffer, the table of neighbor leaves

}  // namespace

CaptureBuffers CaptureBuffers::make() {
  return {.feedback = gl::GlBuffer::make(),
          .staging = gl::GlBuffer::make(),
          .size = 0,
          .sites = gl::GlBuffer::make(),
          .site_texture = gl::GlTexture::make(),
          .generated = gl::GlQuery::make(),
          .written = gl::GlQuery::make()};
}

CellCapture::CellCapture(const gl::GlContext& context, CaptureBuffers& buffers, GpuPipeline pipeline,
                         std::size_t words_per_vertex, std::uint64_t feedback_bytes)
    : context_(context),
      buffers_(buffers),
      pipeline_(pipeline),
      words_(words_per_vertex),
      feedback_bytes_(feedback_bytes),
      // llvmpipe repeats vertices in a draw of more than 65,536 tessellated vertices.
      patches_per_draw_(context.device().software ? 65536 / kCellsPerSite : kMaxSites),
      max_sites_(0),
      next_sites_(0) {
  GLint texels = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
  max_sites_ = std::min(kMaxSites, static_cast<std::size_t>(texels) / kTexelsPerSite);
  next_sites_ = max_sites_;
}

void CellCapture::draw_sites(const gl::ShaderProgram& program, std::size_t sites) const {
  const auto cells = static_cast<GLsizei>(sites * kCellsPerSite);
  switch (pipeline_) {
    case GpuPipeline::mt_geometry: glDrawArrays(GL_LINES_ADJACENCY, 0, 24 * cells); return;
    case GpuPipeline::mc_points: glDrawArrays(GL_POINTS, 0, cells); return;
    case GpuPipeline::mc_tessellation: break;
  }
  for (std::size_t first = 0; first < sites; first += patches_per_draw_) {
    program.set("first_site", static_cast<int>(first));
    glDrawArrays(GL_PATCHES, 0, static_cast<GLsizei>(std::min(patches_per_draw_, sites - first)));
  }
}

Result<std::uint64_t> CellCapture::count(const gl::ShaderProgram& program, std::size_t sites) {
  const Stopwatch watch;
  program.use();
  glBeginQuery(GL_PRIMITIVES_GENERATED, buffers_.generated.name());
  draw_sites(program, sites);
  glEndQuery(GL_PRIMITIVES_GENERATED);
  GLuint64 triangles = 0;
  glGetQueryObjectui64v(buffers_.generated.name(), GL_QUERY_RESULT, &triangles);
  times_.count += watch.elapsed();
  TRY(context_.check("counting triangles"));
  return triangles;
}

Result<void> CellCapture::draw(const gl::CountAndCapture& pass, std::span<const glm::ivec3> origins, const Bind& bind,
                               const Take& take, const Allow& allow) {
  std::vector<glm::ivec4> texels;
  for (std::size_t first = 0; first < origins.size();) {
    const std::size_t many = std::min(next_sites_, origins.size() - first);
    texels.resize(many);
    for (std::size_t s = 0; s < many; ++s) texels[s] = glm::ivec4(origins[first + s], 0);
    glBindBuffer(GL_TEXTURE_BUFFER, buffers_.sites.name());
    glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(many * sizeof(glm::ivec4)), texels.data(), GL_STREAM_DRAW);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_BUFFER, buffers_.site_texture.name());
    glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32I, buffers_.sites.name());
    for (const gl::ShaderProgram* program : pass.programs()) program->set("sites", 0);
    bind(first, many);

    const auto triangles = TRY(count(*pass.count, many));
    const std::uint64_t words = triangles * 3 * words_;
    const std::uint64_t bytes = words * sizeof(std::uint32_t);
    // Sizes the next draw by the bytes per site of this draw.
    constexpr double kRoom = 0.8;
    const double fitting =
        kRoom * static_cast<double>(feedback_bytes_) / static_cast<double>(std::max<std::uint64_t>(bytes, 1));
    next_sites_ =
        static_cast<std::size_t>(std::clamp(static_cast<double>(many) * fitting, 1.0, static_cast<double>(max_sites_)));
    if (bytes > feedback_bytes_ && many > 1) {
      next_sites_ = std::min(next_sites_, many - 1);
      continue;
    }
    TRY(allow(triangles_ + triangles));
    triangles_ += triangles;
    if (triangles > 0) {
      Stopwatch watch;
      glBindBuffer(GL_TRANSFORM_FEEDBACK_BUFFER, buffers_.feedback.name());
      if (bytes > buffers_.size) {
        buffers_.size = 0;
        glBufferData(GL_TRANSFORM_FEEDBACK_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, GL_STREAM_COPY);
        glBindBuffer(GL_COPY_WRITE_BUFFER, buffers_.staging.name());
        glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, GL_STREAM_READ);
        if (auto checked = context_.check(fmt::format("allocating {} for triangles", format_byte_size(bytes)));
            !checked) {
          return checked;
        }
        buffers_.size = bytes;
      }
      glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, buffers_.feedback.name());
      pass.capture->use();
      glBeginQuery(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN, buffers_.written.name());
      glBeginTransformFeedback(GL_TRIANGLES);
      draw_sites(*pass.capture, many);
      glEndTransformFeedback();
      glEndQuery(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN);
      GLuint64 written = 0;
      glGetQueryObjectui64v(buffers_.written.name(), GL_QUERY_RESULT, &written);
      times_.capture += watch.elapsed();
      TRY(context_.check("capturing triangles"));
      if (written != triangles) {
        return fail(ErrorCode::unavailable,
                    fmt::format("{}: the count pass found {} triangles, but transform feedback wrote {}",
                                context_.device().renderer, triangles, written),
                    {{Remedy::report, Setting::devices}, {Remedy::use, Setting::cpu_backend}});
      }
      watch.restart();
      if (soup_.size() < words) soup_ = Buffer<std::uint32_t>(words);
      glBindBuffer(GL_COPY_WRITE_BUFFER, buffers_.staging.name());
      glCopyBufferSubData(GL_TRANSFORM_FEEDBACK_BUFFER, GL_COPY_WRITE_BUFFER, 0, 0, static_cast<GLsizeiptr>(bytes));
      glGetBufferSubData(GL_COPY_WRITE_BUFFER, 0, static_cast<GLsizeiptr>(bytes), soup_.data());
      times_.read_back += watch.elapsed();
      TRY(context_.check("reading triangles back"));
      captured_bytes_ += bytes;
    }
    take(first, many, CapturedSoup{{soup_.data(), words}, words_});
    first += many;
  }
  return {};
}

}  // namespace isoextract::gpu
