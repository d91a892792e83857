#include "gpu/detail/gpu_surface.hpp"

#include <cmath>

#include <utility>

#include <fmt/format.h>

namespace isoextract::gpu {

GpuSurface::GpuSurface(const field::ScalarField& field, const extract::ExtractOptions& options,
                       const DrawingTools& tools, const field::IndexBox& stored, const field::IndexBox& region,
                       const Context& context)
    : field_(field),
      options_(options),
      tools_(tools),
      context_(context),
      pipeline_(pipeline_of(options.method, tools.options).value()),
      table_(extract::case_table(options.method)),
      placement_(extract::output_placement(field, options, stored, region)) {}

void GpuSurface::found(const SurfaceLocation& place, std::unique_ptr<FieldSource> source) {
  place_ = place;
  source_ = std::move(source);
}

std::optional<GpuPipeline> pipeline_of(extract::Method method, const GpuOptions& options) {
  if (method == extract::Method::mt) return GpuPipeline::mt_geometry;
  if (method != extract::Method::mc) return std::nullopt;
  return options.tessellation ? GpuPipeline::mc_tessellation : GpuPipeline::mc_points;
}

Result<gl::CountAndCapture> GpuSurface::find_programs() const {
  CellProgramKind kind;
  kind.pipeline = pipeline_;
  kind.sample_define = sample_format(field_.type()).define;
  kind.sparse = place_.sparse;
  kind.scaled = !field_.scale.is_identity();
  kind.holes = place_.holes;
  kind.swizzle = tools_.options.swizzle;
  CellProgramKind with_normals = kind;
  with_normals.normals = options_.smooth_normals ? CapturedNormals::gradient : CapturedNormals::none;
  const auto capturing = TRY(tools_.programs->find(*tools_.gl, with_normals));
  kind.counting = true;
  const auto counting = TRY(tools_.programs->find(*tools_.gl, kind));
  return gl::CountAndCapture{counting, capturing};
}

void GpuSurface::set_uniforms(const gl::ShaderProgram& program) const {
  program.set("inside_from", place_.inside_keys.from);
  program.set("inside_to", place_.inside_keys.to);
  program.set("first_cell", place_.region.min);
  program.set("last_cell", place_.region.max - 1);
  program.set("last_sample", place_.stored.max);
  program.set("iso_value", options_.iso);
  program.set("edge_margin", placement_.margin());
  program.set("value_slope", field_.scale.slope);
  program.set("value_intercept", field_.scale.intercept);
  const field::Affine& local = placement_.local_from_index();
  program.set("local_x", local.linear[0]);
  program.set("local_y", local.linear[1]);
  program.set("local_z", local.linear[2]);
  program.set("local_offset", local.offset);
  const glm::dmat3 outward = placement_.outward_covectors();
  program.set("covector_x", outward[0]);
  program.set("covector_y", outward[1]);
  program.set("covector_z", outward[2]);
}

Result<extract::MeshSizes> GpuSurface::count(extract::ExtractStats& stats) {
  const Stopwatch compiling;
  const auto pass = TRY(find_programs());
  extract::DeviceStats& device = stats.device.emplace();
  device.compile = compiling.elapsed();
  for (const gl::ShaderProgram* program : pass.programs()) set_uniforms(*program);

  auto memory = TRY(context_.reserve(
      SiteWeld::bytes(place_.origins.size(), table_.directions.size()),
      fmt::format("{}: the table of the {} bricks that the surface crosses", field_.source, place_.origins.size())));
  sites_memory_ = std::move(memory);
  weld_.emplace(
      table_, place_.origins, [this](std::size_t site) { return near(site); },
      [this](const glm::ivec3& cell) { return decide(cell); });
  CellCapture capture(*tools_.gl, *tools_.buffers, pipeline_, words_a_vertex(), tools_.memory.feedback);
  TRY(draw(pass, capture));
  capture.free_soup();
  soup_memory_.release();
  const auto sizes = TRY(weld_->number());

  const UploadFigures uploads = source_->uploads();
  stats.hole_cells = hole_cells_.load();
  device.bytes_uploaded = uploads.bytes;
  device.samples_uploaded = uploads.samples;
  device.samples_kept = uploads.samples_kept;
  device.bricks_uploaded = uploads.bricks;
  device.bricks_kept = uploads.bricks_kept;
  device.bytes_captured = capture.captured_bytes();
  device.cells_decided = weld_->decided_cells() - stats.hole_cells;  // decided cells that were left out count as holes
  device.upload = uploads.time;
  device.capture = capture.times().capture;
  device.read_back = capture.times().read_back;
  device.weld = weld_->time();
  stats.count = capture.times().count;
  for (const StageTime& part : {device.capture, device.read_back, device.weld}) stats.emit += part;
  return sizes;
}

Result<void> GpuSurface::draw(const gl::CountAndCapture& pass, CellCapture& capture) {
  context_.progress().begin("drawing cells", place_.origins.size());
  while (true) {
    TRY(context_.check());
    const auto ready = TRY(source_->advance());
    if (ready.empty()) break;
    TRY(draw_batch(pass, ready, capture));
  }
  const auto& messages = tools_.gl->debug_messages();
  if (!tools_.options.debug || messages.empty()) return {};
  return fail(ErrorCode::unavailable,
              fmt::format("{}: driver message: {}", gl::describe(tools_.gl->device()), messages.front()));
}

Result<void> GpuSurface::draw_batch(const gl::CountAndCapture& pass, std::span<const std::uint32_t> ready,
                                    CellCapture& capture) {
  std::vector<glm::ivec3> origins(ready.size());
  for (std::size_t s = 0; s < ready.size(); ++s) origins[s] = place_.origins[ready[s]];
  return capture.draw(
      pass, origins, [&](std::size_t first, std::size_t count) { source_->bind(pass, ready.subspan(first, count)); },
      [&](std::size_t first, std::size_t count, const CapturedSoup& soup) {
        weld(ready.subspan(first, count), soup);
        context_.progress().advance(count);
      },
      [&](std::uint64_t triangles) { return make_room(triangles); });
}

Result<void> GpuSurface::make_room(std::uint64_t triangles) {
  const std::uint64_t soup = (triangles - triangles_) * 3 * words_a_vertex() * sizeof(std::uint32_t);
  const std::string what = fmt::format("{}: the {} triangles of its surface", field_.source, triangles);
  triangles_ = triangles;
  if (soup > soup_memory_.bytes()) {
    soup_memory_.release();
    soup_memory_ = TRY(context_.reserve(soup, what));
  }
  // The weld shares vertices, so it takes less memory than the captured triangles; how much less is known afterwards.
  auto memory = TRY(context_.reserve(soup, what));
  weld_memory_.push_back(std::move(memory));
  return {};
}

void GpuSurface::weld(std::span<const std::uint32_t> sites, const CapturedSoup& soup) {
  const std::uint64_t before = weld_->piece_bytes();
  weld_->add(sites, soup);
  weld_memory_.back().shrink(weld_->piece_bytes() - before);
}

unsigned GpuSurface::decide(const glm::ivec3& cell) {
  if (place_.holes && touches_nan(cell)) {
    hole_cells_.fetch_add(1, std::memory_order_relaxed);
    return table_.variants[0];
  }
  unsigned cell_case = 0;
  for (int c = 0; c < 8; ++c) cell_case |= (inside(cell + extract::direction_step(c)) ? 1U : 0U) << c;
  return extract::cell_variant(table_, cell_case, extract::InsideRule{field_.kind, options_.iso},
                               [&](int c) { return value(cell + extract::direction_step(c)); });
}

bool GpuSurface::touches_nan(const glm::ivec3& cell) const {
  for (int c = 0; c < 8; ++c) {
    if (std::isnan(value(cell + extract::direction_step(c)))) return true;
  }
  return false;
}

Result<void> GpuSurface::emit(mesh::Mesh& mesh) const {
  weld_->write(mesh, placement_.mirrored());
  return {};
}

std::uint32_t GpuSurface::edge_vertex(const glm::ivec3& p, int direction) const {
  const auto owner = static_cast<std::size_t>(site(p));
  return weld_->vertex_at(owner, direction, field::block_offset(p - place_.origins[owner]));
}

}  // namespace isoextract::gpu
