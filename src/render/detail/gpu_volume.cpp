#include "render/detail/gpu_volume.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/byte_size.hpp"
#include "base/parallel.hpp"
#include "render/detail/volume_bricks.hpp"
#include "render/detail/volume_nodes.hpp"
#include "render/detail/volume_samples.hpp"

namespace isoextract::render::detail {
namespace {

constexpr int kBrickSide = VolumeBricks::kCells + 1;  // in samples
constexpr std::uint64_t kBrickSamples = std::uint64_t{kBrickSide} * kBrickSide * kBrickSide;
constexpr float kNanInShader = 3e38F;           // stands for NaN in the shader, since GLSL need not support NaN
constexpr std::uint64_t kBatchSlots = 1 << 12;  // uploads about 12 MB at a time
constexpr double kMostSlabs = 1e9;              // per ray: the shader numbers slabs by int

gl::GlTexture make_texture(GLenum format, const glm::ivec3& size) {
  gl::GlTexture texture = gl::GlTexture::make();
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_3D, texture.name());
  glTexStorage3D(GL_TEXTURE_3D, 1, format, size.x, size.y, size.z);
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return texture;
}

// Writes the samples of bricks in the order of the atlas rows.
template <class T>
class BrickWriter {
 public:
  BrickWriter(const VolumeSamples& samples, const VolumeNodes& nodes, const glm::ivec3& slots)
      : samples_(samples),
        nodes_(nodes),
        row_(static_cast<std::size_t>(slots.x)),
        last_(samples.dense() != nullptr ? samples.dense()->dims - 1 : glm::ivec3(field::kMaxSparseIndex)) {}

  // Writes row `number` of slots to `values`: kBrickSide^2 lines through all bricks of the row.
  void write(std::size_t number, float* values) const {
    SampleReader<T> reader(samples_);
    const std::size_t width = row_ * kBrickSide;
    for (std::size_t n = 0; n < row_ && number * row_ + n < nodes_.slots().size(); ++n) {
      const glm::ivec3& origin = nodes_.slots()[number * row_ + n];
      float* to = values + n * kBrickSide;
      for (int k = 0; k < kBrickSide; ++k) {
        for (int j = 0; j < kBrickSide; ++j, to += width) {
          // Samples beyond the last one belong to cells that no ray visits, so any value will do.
          for (int i = 0; i < kBrickSide; ++i) {
            const float position = reader(glm::min(origin + glm::ivec3(i, j, k), last_));
            to[i] = std::isnan(position) ? kNanInShader : position;
          }
        }
      }
    }
  }

 private:
  const VolumeSamples& samples_;
  const VolumeNodes& nodes_;
  std::size_t row_;
  glm::ivec3 last_;
};

Result<void> write_atlas(const gl::GlContext& gl, const VolumeSamples& samples, const VolumeNodes& nodes,
                         const glm::ivec3& slots, const Context& context) {
  const auto row = static_cast<std::uint64_t>(slots.x);
  const std::uint64_t rows = (nodes.slots().size() + row - 1) / row;
  const std::uint64_t batch = std::max<std::uint64_t>(1, kBatchSlots / row);
  const std::uint64_t bytes = std::min(batch, rows) * row * kBrickSamples * sizeof(float);
  const auto memory = TRY(context.reserve(bytes, samples.field().source + ": the upload buffer of its bricks"));
  std::vector<float> values(bytes / sizeof(float));
  context.progress().begin("uploading bricks", rows);
  return field::visit_sample_type(samples.field().type(), [&]<class T>(std::type_identity<T>) -> Result<void> {
    const BrickWriter<T> writer(samples, nodes, slots);
    for (std::uint64_t first = 0; first < rows; first += batch) {
      const std::uint64_t count = std::min(batch, rows - first);
      for_each_index(count, [&](std::uint64_t n) { writer.write(first + n, values.data() + n * row * kBrickSamples); });
      for (std::uint64_t n = 0; n < count; ++n) {
        const auto number = static_cast<int>(first + n);
        glTexSubImage3D(GL_TEXTURE_3D, 0, 0, kBrickSide * (number % slots.y), kBrickSide * (number / slots.y),
                        kBrickSide * slots.x, kBrickSide, kBrickSide, GL_RED, GL_FLOAT,
                        values.data() + n * row * kBrickSamples);
      }
      context.progress().advance(count);
      TRY(context.check());
      TRY(gl.check("uploading bricks"));
    }
    return {};
  });
}

// Returns the length of the box's three edges together, in the world: no ray in the box is longer.
double longest_way(const Volume& volume) {
  const field::Box box = *volume_box(*volume.field);
  const glm::dvec3 extent = box.max - box.min;
  const glm::dmat3& axes = volume.index_to_world.linear;
  return extent.x * glm::length(axes[0]) + extent.y * glm::length(axes[1]) + extent.z * glm::length(axes[2]);
}

}  // namespace

Result<void> GpuVolume::make_atlas(const gl::GlContext& gl, const std::string& source, std::uint64_t slots,
                                   GpuMemory& memory) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &most);
  const auto along = static_cast<std::uint64_t>(most / kBrickSide);
  const auto divided = [](std::uint64_t a, std::uint64_t b) { return std::max<std::uint64_t>((a + b - 1) / b, 1); };
  // Chooses dimensions with few unused slots.
  const std::uint64_t layers = divided(slots, along * along);
  const std::uint64_t rows = divided(slots, along * layers);
  const std::uint64_t row = divided(slots, rows * layers);
  const std::string what = fmt::format("{} bricks of {}", slots, source);
  if (layers > along) {
    return fail(ErrorCode::unavailable,
                fmt::format("{}: the device has no texture large enough for {}", gl.device().renderer, what),
                {Remedy::use, Setting::cpu_backend});
  }
  const std::uint64_t bytes = row * rows * layers * kBrickSamples * sizeof(float);
  TRY(memory.take(bytes, what));
  slots_ = glm::ivec3(glm::u64vec3(row, rows, layers));
  atlas_ = make_texture(GL_R32F, kBrickSide * slots_);
  return gl.check(fmt::format("allocating {} for {}", format_byte_size(bytes), what));
}

struct GpuVolume::Names {
  const char* nodes;
  const char* bricks;
  const char* atlas;
  const char* transfer;
  const char* first_node;
  const char* atlas_slots;
  const char* first_cell;
  const char* last_cell;
  const char* box_min;
  const char* box_max;
  const char* eye;
  const char* index_of_view;
  TextureUnit first_unit;  // the other three textures follow
};

Result<GpuVolume> GpuVolume::upload(const gl::GlContext& gl, const Volume& volume, const RenderOptions& options,
                                    RenderStatistics& statistics, GpuMemory& memory, const Context& context) {
  const double step = step_of(volume, options);
  double way = longest_way(volume);
  if (volume.emission != nullptr) way += longest_way(*volume.emission);
  if (!(way / step < kMostSlabs)) {
    return fail(ErrorCode::unavailable,
                fmt::format("{}: expected at most {:g} samples along a ray, found {:g}", volume.field->source,
                            kMostSlabs, way / step),
                {Remedy::use, Setting::cpu_backend});
  }
  GpuVolume made = TRY(upload_field(gl, volume, options, statistics, memory, context));
  made.step_ = step;
  if (volume.emission != nullptr) {
    auto emission = TRY(upload_field(gl, *volume.emission, options, statistics, memory, context));
    made.emission_ = std::make_unique<GpuVolume>(std::move(emission));
  }
  return made;
}

Result<GpuVolume> GpuVolume::upload_field(const gl::GlContext& gl, const Volume& volume, const RenderOptions& options,
                                          RenderStatistics& statistics, GpuMemory& memory, const Context& context) {
  GpuVolume made;
  made.volume_ = &volume;
  made.box_ = *volume_box(*volume.field);
  const std::string& source = volume.field->source;
  const glm::dvec3 extent = made.box_.max - made.box_.min;

  auto samples = TRY(VolumeSamples::open(volume, context));
  std::optional<VolumeBricks> seen;
  if (options.empty_space_skipping) {
    auto measured = TRY(VolumeBricks::measure(samples, context));
    seen.emplace(std::move(measured));
    statistics.bricks += seen->count();
    statistics.bricks_skipped += seen->count_invisible();
  }
  const auto nodes = TRY(VolumeNodes::list(samples, seen ? &*seen : nullptr, glm::ivec3(made.box_.min),
                                           glm::ivec3(made.box_.max) - 1, context));

  made.first_node_ = nodes.first();
  GLint most = 0;
  glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &most);
  const glm::ivec3& dims = nodes.dims();
  if (std::max({dims.x, dims.y, dims.z}) > most) {
    return fail(
        ErrorCode::unavailable,
        fmt::format("{}: {}: expected at most {} voxels along an axis, found {:g} x {:g} x {:g}", gl.device().renderer,
                    source, std::int64_t{most} * VolumeNodes::kCells, extent.x, extent.y, extent.z),
        {Remedy::use, Setting::cpu_backend});
  }
  TRY(memory.take(nodes.nodes().size() * sizeof(std::int32_t), source + ": brick indices"));
  made.nodes_ = make_texture(GL_R32I, dims);
  glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, dims.x, dims.y, dims.z, GL_RED_INTEGER, GL_INT, nodes.nodes().data());

  auto bricks =
      TRY(GpuArray::make(gl, GL_R32I, nodes.bricks().size(), sizeof(std::int32_t), source + ": brick indices", memory));
  made.bricks_ = std::move(bricks);
  made.bricks_.write(0, nodes.bricks().size(), nodes.bricks().data());

  const auto& table = volume.transfer.table();
  made.transfer_ =
      TRY(GpuArray::make(gl, GL_RGBA32F, table.size(), sizeof(glm::vec4), "the transfer function", memory));
  made.transfer_.write(0, table.size(), table.data());

  TRY(made.make_atlas(gl, source, nodes.slots().size(), memory));
  TRY(write_atlas(gl, samples, nodes, made.slots_, context));
  return made;
}

void GpuVolume::bind(const gl::ShaderProgram& program, const Camera& camera) const {
  static constexpr Names kVolume{"nodes",       "bricks",        "atlas",           "transfer", "first_node",
                                 "atlas_slots", "first_cell",    "last_cell",       "box_min",  "box_max",
                                 "volume_eye",  "index_of_view", TextureUnit::nodes};
  static constexpr Names kEmission{"emission_nodes",           "emission_bricks",     "emission_atlas",
                                   "emission_transfer",        "emission_first_node", "emission_atlas_slots",
                                   "emission_first_cell",      "emission_last_cell",  "emission_box_min",
                                   "emission_box_max",         "emission_eye",        "emission_index_of_view",
                                   TextureUnit::emission_nodes};
  bind_field(program, camera, kVolume);
  if (emission_) emission_->bind_field(program, camera, kEmission);
  program.set("world_step", step_);
  program.set("unit_lengths", 1 / volume_->unit_length);
}

void GpuVolume::bind_field(const gl::ShaderProgram& program, const Camera& camera, const Names& names) const {
  const auto unit = [&](int number) { return static_cast<TextureUnit>(static_cast<int>(names.first_unit) + number); };
  bind_texture(program, names.nodes, unit(0), GL_TEXTURE_3D, nodes_);
  bricks_.bind(program, names.bricks, unit(1));
  bind_texture(program, names.atlas, unit(2), GL_TEXTURE_3D, atlas_);
  transfer_.bind(program, names.transfer, unit(3));
  program.set(names.first_node, first_node_);
  program.set(names.atlas_slots, slots_);
  program.set(names.first_cell, glm::ivec3(box_.min));
  program.set(names.last_cell, glm::ivec3(box_.max) - 1);
  program.set(names.box_min, box_.min);
  program.set(names.box_max, box_.max);
  const field::Affine index_of_world = volume_->index_to_world.inverse();
  program.set(names.eye, index_of_world(camera.eye));
  program.set(names.index_of_view, index_of_world.linear * camera.world_from_view().linear);
}

}  // namespace isoextract::render::detail
