#include "gpu/thread_creation.hpp"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include "base/median.hpp"
#include "gl/gl_program.hpp"

namespace isoextract::gpu {
namespace {

// Starts one thread a cell of a grid, in draws of a size that the device can take.
class ThreadPass {
 public:
  ThreadPass(const gl::GlContext& context, ThreadMaker maker, int size)
      : context_(context), maker_(maker), size_(size), layer_cells_(static_cast<std::uint64_t>(size) * size) {}

  ThreadPass(const ThreadPass&) = delete;
  ThreadPass& operator=(const ThreadPass&) = delete;
  ~ThreadPass() { glDisableVertexAttribArray(0); }

  [[nodiscard]] std::uint64_t cells() const { return layer_cells_ * static_cast<std::uint64_t>(size_); }
  [[nodiscard]] std::uint64_t buffer_bytes() const { return buffer_bytes_; }

  Result<void> prepare() {
    gl::ProgramSource source;
    switch (maker_) {
      case ThreadMaker::tessellation:
        source.stages = {{GL_VERTEX_SHADER, {"threads_patch.vert"}},
                         {GL_TESS_CONTROL_SHADER, {"threads_patch.tesc"}},
                         {GL_TESS_EVALUATION_SHADER, {"threads_patch.tese"}}};
        break;
      case ThreadMaker::dummy_vertices: source.stages = {{GL_VERTEX_SHADER, {"threads_dummy.vert"}}}; break;
      case ThreadMaker::vertex_number: source.stages = {{GL_VERTEX_SHADER, {"threads_numbered.vert"}}}; break;
    }
    source.stages.push_back({GL_GEOMETRY_SHADER, {"threads.geom"}});
    program_ = TRY(gl::ShaderProgram::link(context_, source));
    program_.set("grid", glm::ivec3(size_));
    if (maker_ == ThreadMaker::vertex_number) return {};
    if (maker_ == ThreadMaker::tessellation) choose_patches();
    return fill_buffer();
  }

  // Returns the number of points drawn: one a thread with `emit`, otherwise none. Counting makes sure that no driver
  // skips the threads.
  [[nodiscard]] std::uint64_t count_points(bool emit) const {
    glBeginQuery(GL_PRIMITIVES_GENERATED, query_.name());
    draw(emit);
    glEndQuery(GL_PRIMITIVES_GENERATED);
    GLuint64 points = 0;
    glGetQueryObjectui64v(query_.name(), GL_QUERY_RESULT, &points);
    return points;
  }

  // Fails unless every cell gets its thread.
  [[nodiscard]] Result<void> check_count() const {
    const std::uint64_t threads = count_points(true);
    TRY(context_.check("making threads"));
    if (threads == cells()) return {};
    return fail(ErrorCode::unavailable,
                fmt::format("{} made {} threads for {} cells; expected one per cell", thread_maker_name(maker_),
                            threads, cells()),
                "please report it");
  }

 private:
  void draw(bool emit) const {
    program_.use();
    program_.set("emit_below", emit ? glm::ivec3(size_) : glm::ivec3(0));
    if (maker_ == ThreadMaker::tessellation) {
      for (std::uint64_t first = 0; first < patches_; first += patches_per_draw_) {
        const std::uint64_t count = std::min(patches_per_draw_, patches_ - first);
        glDrawArrays(GL_PATCHES, static_cast<GLint>(4 * first), static_cast<GLsizei>(4 * count));
      }
      return;
    }
    const int layers = layers_per_draw();
    for (int first = 0; first < size_; first += layers) {
      program_.set("first_layer", first);
      if (maker_ == ThreadMaker::dummy_vertices) point_to(layer_cells_ * static_cast<std::uint64_t>(first));
      const auto cells = layer_cells_ * static_cast<std::uint64_t>(std::min(layers, size_ - first));
      glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(cells));
    }
  }

  [[nodiscard]] int layers_per_draw() const {
    constexpr std::uint64_t kCells = 1 << 26;
    return static_cast<int>(std::max<std::uint64_t>(kCells / layer_cells_, 1));
  }

  // Binds the buffer from `vertex` on.
  void point_to(std::uint64_t vertex) const {
    const std::uint64_t bytes = vertex * sizeof(std::uint32_t);
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
    // NOLINTNEXTLINE(performance-no-int-to-ptr): GL takes an offset as a pointer
    glVertexAttribIPointer(0, 1, GL_UNSIGNED_INT, 0, reinterpret_cast<const void*>(bytes));
  }

  void choose_patches() {
    GLint level = 64;
    glGetIntegerv(GL_MAX_TESS_GEN_LEVEL, &level);
    // llvmpipe draws correctly only up to 65,536 tessellated vertices: 16 patches of 64x64.
    const int side = context_.device().software ? 64 : level + 1;
    const int along = (size_ + side - 1) / side;
    patches_ = static_cast<std::uint64_t>(along) * along * static_cast<std::uint64_t>(size_);
    if (context_.device().software) patches_per_draw_ = 16;
    program_.set("patches", glm::ivec2(along));
    program_.set("patch_cells", side);
  }

  // Fills the buffer with a number for each vertex: of its cell within a draw, or of its patch, which has four
  // vertices.
  Result<void> fill_buffer() {
    const bool patches = maker_ == ThreadMaker::tessellation;
    const std::uint64_t vertices = patches ? 4 * patches_ : cells();
    const std::uint64_t of_draw = layer_cells_ * static_cast<std::uint64_t>(layers_per_draw());
    buffer_bytes_ = vertices * sizeof(std::uint32_t);
    buffer_ = gl::GlBuffer::make();
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(buffer_bytes_), nullptr, GL_STATIC_DRAW);
    TRY(context_.check("allocating memory for vertices"));
    constexpr std::uint64_t kPortion = 1 << 22;
    std::vector<std::uint32_t> numbers;
    for (std::uint64_t first = 0; first < vertices; first += kPortion) {
      numbers.resize(static_cast<std::size_t>(std::min(kPortion, vertices - first)));
      for (std::size_t v = 0; v < numbers.size(); ++v) {
        numbers[v] = static_cast<std::uint32_t>(patches ? (first + v) / 4 : (first + v) % of_draw);
      }
      glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(first * sizeof(std::uint32_t)),
                      static_cast<GLsizeiptr>(numbers.size() * sizeof(std::uint32_t)), numbers.data());
    }
    glEnableVertexAttribArray(0);
    point_to(0);
    glPatchParameteri(GL_PATCH_VERTICES, 4);
    return context_.check("filling a buffer of vertices");
  }

  const gl::GlContext& context_;
  ThreadMaker maker_;
  int size_;
  std::uint64_t layer_cells_;
  std::uint64_t patches_ = 0;
  std::uint64_t patches_per_draw_ = 1 << 20;
  std::uint64_t buffer_bytes_ = 0;
  gl::ShaderProgram program_;
  gl::GlBuffer buffer_;
  gl::GlQuery query_ = gl::GlQuery::make();
};

std::optional<std::uint64_t> free_memory() {
  if (!epoxy_has_gl_extension("GL_NVX_gpu_memory_info")) return std::nullopt;
  GLint kilobytes = 0;
  glGetIntegerv(GL_GPU_MEMORY_INFO_CURRENT_AVAILABLE_VIDMEM_NVX, &kilobytes);
  return std::uint64_t{1024} * static_cast<std::uint64_t>(kilobytes);
}

template <class F>
std::vector<double> timed(int repeats, const F& f) {
  std::vector<double> seconds;
  for (int run = -1; run < repeats; ++run) {
    glFinish();
    const auto start = std::chrono::steady_clock::now();
    f();
    glFinish();
    const double taken = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (run >= 0) seconds.push_back(taken);  // the first run is a warm-up
  }
  return seconds;
}

Result<void> measure(const gl::GlContext& context, int size, int repeats, ThreadCreation& row) {
  glFinish();
  const auto before = free_memory();
  ThreadPass pass(context, row.maker, size);
  TRY(pass.prepare());
  TRY(pass.check_count());
  std::uint64_t points = 0;
  const std::vector<double> seconds = timed(repeats, [&] { points += pass.count_points(false); });
  row.median_seconds = median(seconds);
  row.min_seconds = std::ranges::min(seconds);
  row.max_seconds = std::ranges::max(seconds);
  row.buffer_bytes = pass.buffer_bytes();
  if (const auto after = free_memory(); before && after && *before >= *after) row.driver_bytes = *before - *after;
  if (points != 0) {
    return fail(ErrorCode::unavailable, fmt::format("the GPU drew {} points in a pass that must draw none", points),
                {Remedy::report, Setting::devices});
  }
  return context.check("timing threads");
}

double copy_bandwidth(const gl::GlContext& context, int repeats) {
  const GLsizeiptr bytes = context.device().software ? 1 << 26 : 1 << 29;
  const gl::GlBuffer from = gl::GlBuffer::make();
  const gl::GlBuffer to = gl::GlBuffer::make();
  glBindBuffer(GL_COPY_READ_BUFFER, from.name());
  glBufferData(GL_COPY_READ_BUFFER, bytes, nullptr, GL_STATIC_COPY);
  glBindBuffer(GL_COPY_WRITE_BUFFER, to.name());
  glBufferData(GL_COPY_WRITE_BUFFER, bytes, nullptr, GL_STATIC_COPY);
  const std::vector<double> seconds =
      timed(repeats, [&] { glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, 0, bytes); });
  return 2 * static_cast<double>(bytes) / median(seconds);
}

}  // namespace

Result<ThreadCreationResult> measure_thread_creation(const gl::DeviceChoice& device, const std::vector<int>& sizes,
                                                     int repeats) {
  const auto context = TRY(gl::GlContext::open({device, false}));
  ThreadCreationResult result;
  result.device = context->device();
  result.copy_bytes_per_second = copy_bandwidth(*context, repeats);
  TRY(context->check("copying a buffer"));
  for (const int size : sizes) {
    ThreadCreationLevel level{size, {}};
    for (const ThreadMaker maker :
         {ThreadMaker::tessellation, ThreadMaker::dummy_vertices, ThreadMaker::vertex_number}) {
      ThreadCreation row;
      row.maker = maker;
      if (auto done = measure(*context, size, repeats, row); !done) row.problem = done.error().message;
      level.makers.push_back(row);
    }
    result.levels.push_back(level);
  }
  return result;
}

std::string_view thread_maker_name(ThreadMaker maker) {
  switch (maker) {
    case ThreadMaker::tessellation: return "tessellation";
    case ThreadMaker::dummy_vertices: return "dummy vertices";
    case ThreadMaker::vertex_number: break;
  }
  return "vertex number";
}

}  // namespace isoextract::gpu
