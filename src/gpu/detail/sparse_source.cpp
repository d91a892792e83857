#include "gpu/detail/sparse_source.hpp"

#include <algorithm>
#include <numeric>

namespace isoextract::gpu {
namespace {

constexpr int kSize = field::SparseBlock::kSize;
constexpr std::uint64_t kBlockSamples = 512;

}  // namespace

SparseSource::SparseSource(const gl::GlContext& context, const field::SparseSamples& samples,
                           const extract::SparseSites& sites, const SourceOptions& options)
    : context_(&context),
      samples_(&samples),
      sites_(&sites),
      options_(options),
      format_(sample_format(samples.type)),
      order_(sites.origins().size()),
      slot_of_(samples.blocks.size(), -1) {
  std::iota(order_.begin(), order_.end(), 0U);
  // Sorts all sites by origin. Sites without a leaf come beside their neighbors, so fewer leaves are uploaded twice.
  std::ranges::sort(order_, {}, [&](std::uint32_t s) {
    const glm::ivec3& p = sites.origins()[s];
    return std::tuple(p.x, p.y, p.z);
  });
}

Result<SparseSource> SparseSource::make(const gl::GlContext& context, const field::SparseSamples& samples,
                                        const extract::SparseSites& sites, const SourceOptions& options) {
  SparseSource source(context, samples, sites, options);
  if (sites.origins().empty()) return source;
  const std::uint64_t leaf_bytes = kBlockSamples * field::sample_size(samples.type);
  const std::uint64_t along = static_cast<std::uint64_t>(options.max_texture_size) / kSize;
  const std::uint64_t fitting = std::min(options.bytes / leaf_bytes, along * along * along);
  const std::uint64_t places = options.gradients ? extract::kNearPlaces : 8;
  const std::uint64_t wanted = std::clamp<std::uint64_t>(samples.blocks.size(), 1, places * sites.origins().size());
  const std::uint64_t slots = std::min(fitting, wanted);
  // Finds a box of slots that wastes few slots by rounding, and none if all leaves fit.
  const auto divided = [](std::uint64_t a, std::uint64_t b) { return std::max<std::uint64_t>((a + b - 1) / b, 1); };
  const std::uint64_t layers = divided(slots, along * along);
  const std::uint64_t rows = divided(slots, along * layers);
  const bool rounded_up = divided(slots, rows * layers) * rows * layers <= fitting;
  const std::uint64_t row = rounded_up ? divided(slots, rows * layers) : slots / (rows * layers);
  if (row * rows * layers < std::min<std::uint64_t>(extract::kNearPlaces, wanted)) {
    return too_little_memory(options.bytes, std::min<std::uint64_t>(extract::kNearPlaces, wanted) * leaf_bytes);
  }
  source.slots_ = glm::ivec3(glm::u64vec3(row, rows, layers));
  const int count = source.slots_.x * source.slots_.y * source.slots_.z;
  source.block_in_.assign(static_cast<std::size_t>(count), -1);
  source.used_in_.assign(static_cast<std::size_t>(count), 0);
  for (int slot = 0; slot < count; ++slot) source.by_age_.push_back(slot);

  source.atlas_ = TRY(make_sample_texture(context, samples.type, kSize * source.slots_));
  source.neighbor_buffer_ = gl::GlBuffer::make();
  source.neighbor_texture_ = gl::GlTexture::make();
  source.constant_buffer_ = gl::GlBuffer::make();
  source.constant_texture_ = gl::GlTexture::make();
  return source;
}

template <class F>
void SparseSource::for_each_place(std::uint32_t site, const F& f) const {
  extract::for_each_near_place(sites_->origins()[site], options_.gradients ? -1 : 0, f);
}

// Returns a slot that this round does not need, or -1.
std::int32_t SparseSource::take_slot() {
  for (std::size_t tried = 0; tried < by_age_.size(); ++tried) {
    const std::int32_t slot = by_age_.front();
    by_age_.pop_front();
    by_age_.push_back(slot);
    if (used_in_[static_cast<std::size_t>(slot)] == round_) continue;
    std::int32_t& block = block_in_[static_cast<std::size_t>(slot)];
    if (block >= 0) slot_of_[static_cast<std::size_t>(block)] = -1;
    block = -1;
    return slot;
  }
  return -1;
}

void SparseSource::upload(std::int32_t block, std::int32_t slot) {
  const glm::ivec3 at = kSize * glm::ivec3(slot % slots_.x, slot / slots_.x % slots_.y, slot / (slots_.x * slots_.y));
  // The values of a block have z fastest, so z becomes the first axis of the texture.
  glTexSubImage3D(GL_TEXTURE_3D, 0, at.x, at.y, at.z, kSize, kSize, kSize, format_.format, format_.type,
                  samples_->blocks[static_cast<std::size_t>(block)].values);
  uploads_.samples += kBlockSamples;
}

// Uploads the leaves that a site needs. Returns false if the atlas has no room for them next to the leaves of this
// round.
bool SparseSource::make_resident(std::uint32_t site) {
  bool fits = true;
  for_each_place(site, [&](std::size_t, const glm::ivec3& place) {
    const std::int32_t block = sites_->lookup().block(place);
    if (block < 0 || !fits) return;
    std::int32_t& slot = slot_of_[static_cast<std::size_t>(block)];
    if (slot < 0) {
      const std::int32_t free = take_slot();
      if (free < 0) {
        fits = false;
        return;
      }
      slot = free;
      block_in_[static_cast<std::size_t>(slot)] = block;
      upload(block, slot);
    }
    used_in_[static_cast<std::size_t>(slot)] = round_;
  });
  return fits;
}

Result<std::span<const std::uint32_t>> SparseSource::advance() {
  const Stopwatch watch;
  const std::size_t begin = next_;
  ++round_;
  glBindTexture(GL_TEXTURE_3D, atlas_.name());
  while (next_ < order_.size() && make_resident(order_[next_])) ++next_;
  glFinish();  // GL may delay uploads until here
  uploads_.time += watch.elapsed();
  TRY(context_->check("uploading samples"));
  return std::span<const std::uint32_t>(order_).subspan(begin, next_ - begin);
}

// Returns the number of the constant that stands for all samples of a place without a block.
std::int32_t SparseSource::constant_at(const glm::ivec3& place) {
  const double value = sites_->lookup().constant(place);
  const glm::uvec2 words = visit_sample_type(samples_->type, [&]<class T>(std::type_identity<T>) {
    using Wide = std::conditional_t<std::is_same_v<T, field::Half>, float, T>;
    return sample_words(T(static_cast<Wide>(value)));  // exact: the constant was a sample of this type
  });
  const auto [found, fresh] =
      constants_.try_emplace(std::uint64_t{words.y} << 32 | words.x, static_cast<std::int32_t>(constant_words_.size()));
  if (fresh) constant_words_.push_back(words);
  return found->second;
}

void SparseSource::bind(const gl::CountAndCapture& pass, std::span<const std::uint32_t> sites) {
  std::vector<std::int32_t> neighbors(extract::kNearPlaces * sites.size(), -1);
  for (std::size_t s = 0; s < sites.size(); ++s) {
    for_each_place(sites[s], [&](std::size_t place, const glm::ivec3& origin) {
      const std::int32_t block = sites_->lookup().block(origin);
      neighbors[extract::kNearPlaces * s + place] =
          block >= 0 ? slot_of_[static_cast<std::size_t>(block)] : ~constant_at(origin);
    });
  }
  const auto table = [&](int unit, const char* name, const gl::GlBuffer& buffer, const gl::GlTexture& texture,
                         GLenum format, std::size_t bytes, const void* data) {
    glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit));
    glBindBuffer(GL_TEXTURE_BUFFER, buffer.name());
    glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(bytes), data, GL_STREAM_DRAW);
    glBindTexture(GL_TEXTURE_BUFFER, texture.name());
    glTexBuffer(GL_TEXTURE_BUFFER, format, buffer.name());
    for (const gl::ShaderProgram* program : pass.programs()) program->set(name, unit);
  };
  table(3, "neighbors", neighbor_buffer_, neighbor_texture_, GL_R32I, neighbors.size() * sizeof(std::int32_t),
        neighbors.data());
  if (constant_words_.empty()) constant_words_.emplace_back(0);  // an empty buffer is not a valid texture
  table(4, "constants", constant_buffer_, constant_texture_, GL_RG32UI, constant_words_.size() * sizeof(glm::uvec2),
        constant_words_.data());
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_3D, atlas_.name());
  for (const gl::ShaderProgram* program : pass.programs()) program->set("leaf_atlas", 1);
}

UploadFigures SparseSource::uploads() const {
  UploadFigures figures = uploads_;
  figures.bytes = uploads_.samples * field::sample_size(samples_->type);
  const std::uint64_t all = kBlockSamples * samples_->blocks.size();
  figures.left_out = all > uploads_.samples ? all - uploads_.samples : 0;
  return figures;
}

}  // namespace isoextract::gpu
