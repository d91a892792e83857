#include "gpu/detail/dense_source.hpp"

#include <algorithm>
#include <atomic>

#include "base/parallel.hpp"
#include "gpu/detail/dense_sites.hpp"

namespace isoextract::gpu {
namespace {

std::uint64_t volume(const glm::ivec3& size) {
  const glm::u64vec3 wide(size);
  return wide.x * wide.y * wide.z;
}

// Returns the box of the samples that cells of the sites touch.
field::IndexBox box_of(std::span<const glm::ivec3> sites, const field::IndexBox& region) {
  if (sites.empty()) return {};
  field::IndexBox box{sites.front(), sites.front()};
  for (const glm::ivec3& site : sites) {
    box.min = glm::min(box.min, site);
    box.max = glm::max(box.max, site + kBrickCells);
  }
  return {box.min, glm::min(box.max, region.max)};
}

field::IndexBox with_apron(const field::IndexBox& box, int apron, const glm::ivec3& dims) {
  return {glm::max(box.min - apron, glm::ivec3(0)), glm::min(box.max + apron, dims - 1)};
}

}  // namespace

DenseSource::DenseSource(const gl::GlContext& context, const field::DenseSamples& samples,
                         std::span<const glm::ivec3> sites, const field::IndexBox& region, const SourceOptions& options)
    : context_(&context),
      samples_(&samples),
      sites_(sites),
      region_(region),
      options_(options),
      format_(sample_format(samples.type)),
      apron_(options.gradients ? 1 : 0),
      box_(box_of(sites, region)),
      reach_(with_apron(box_, apron_, samples.dims)),
      origin_(region.min - apron_),
      base_(reach_.min),
      column_cells_(0),
      window_(glm::ivec3(1)) {}

Result<DenseSource> DenseSource::make(const gl::GlContext& context, const field::DenseSamples& samples,
                                      std::span<const glm::ivec3> sites, const field::IndexBox& region,
                                      const SourceOptions& options) {
  DenseSource source(context, samples, sites, region, options);
  if (sites.empty()) return source;
  TRY(source.use_resident());
  if (source.options_.resident != nullptr) return source;
  TRY(source.choose_window());
  source.texture_ = TRY(make_sample_texture(context, samples.type, source.window_.size()));
  return source;
}

// Uses resident samples only if all samples that may be needed fit at the same time.
Result<void> DenseSource::use_resident() {
  if (options_.resident == nullptr) return {};
  const field::IndexBox bricks{(reach_.min - origin_) / kBrickSamples, (reach_.max - origin_) / kBrickSamples};
  const auto room = TRY(options_.resident->make_room(*context_, {samples_->type, origin_}, bricks,
                                                     {options_.bytes, options_.max_texture_size}, *options_.host));
  if (!room) {
    options_.resident = nullptr;
    return {};
  }
  base_ = origin_;
  window_ = ToroidalWindow(options_.resident->size());
  column_cells_ = box_.max - box_.min;
  columns_ = glm::ivec2(1);
  return {};
}

// Chooses the window: all samples that may be needed if they fit, else as many whole slices as fit, else the widest
// columns of bricks that fit.
Result<void> DenseSource::choose_window() {
  const glm::ivec3 all(reach_.dims());
  const glm::ivec3 cells = box_.max - box_.min;
  const int least_slices = std::min(kBrickCells + 1 + 2 * apron_, all.z);
  const std::uint64_t size = field::sample_size(samples_->type);
  const int limit = options_.max_texture_size;
  const auto fits = [&](const glm::ivec3& window) {
    return std::max({window.x, window.y, window.z}) <= limit && volume(window) * size <= options_.bytes;
  };
  column_cells_ = cells;
  glm::ivec3 window(all.x, all.y, least_slices);
  // Halves the longer side, in whole bricks, until a slab one brick high fits.
  while (!fits(window)) {
    const int axis = column_cells_.x >= column_cells_.y ? 0 : 1;
    if (column_cells_[axis] <= kBrickCells) {
      return too_little_memory(options_.bytes, volume(window) * size);
    }
    column_cells_[axis] = ((column_cells_[axis] + 1) / 2 + kBrickCells - 1) / kBrickCells * kBrickCells;
    window[axis] = std::min(column_cells_[axis] + 1 + 2 * apron_, all[axis]);
  }
  const std::uint64_t slices = options_.bytes / (volume({window.x, window.y, 1}) * size);
  window.z = static_cast<int>(std::min<std::uint64_t>(slices, static_cast<std::uint64_t>(std::min(all.z, limit))));
  window_ = ToroidalWindow(window);
  columns_ = (glm::ivec2(cells) + column_cells_ - 1) / column_cells_;
  return {};
}

field::IndexBox DenseSource::needed_samples(const glm::ivec3& site) const {
  return {glm::max(site - apron_, reach_.min), glm::min(site + kBrickCells + apron_, reach_.max)};
}

void DenseSource::begin_column() {
  const glm::ivec2 low = glm::ivec2(box_.min) + column_cells_ * glm::ivec2(column_ % columns_.x, column_ / columns_.x);
  const glm::ivec2 high = low + column_cells_;  // one past the last cell
  column_sites_.clear();
  next_ = 0;
  for (std::size_t s = 0; s < sites_.size(); ++s) {
    const glm::ivec2 at(sites_[s]);
    if (glm::all(glm::greaterThanEqual(at, low)) && glm::all(glm::lessThan(at, high))) {
      column_sites_.push_back(static_cast<std::uint32_t>(s));
    }
  }
  column_reach_.min = glm::max(glm::ivec3(low - apron_, reach_.min.z), reach_.min);
  column_reach_.max = glm::min(glm::ivec3(high + apron_, reach_.max.z), reach_.max);
  first_brick_ = (column_reach_.min - origin_) / kBrickSamples;
  bricks_ = (column_reach_.max - origin_) / kBrickSamples - first_brick_ + 1;
  needed_.assign(volume(bricks_), 0);
  for (const std::uint32_t s : column_sites_) {
    const field::IndexBox need = needed_samples(sites_[s]);
    const glm::ivec3 first = (need.min - origin_) / kBrickSamples - first_brick_;
    const glm::ivec3 last = (need.max - origin_) / kBrickSamples - first_brick_;
    for (int z = first.z; z <= last.z; ++z) {
      for (int y = first.y; y <= last.y; ++y) {
        std::uint8_t* row = needed_.data() + bricks_.x * (y + static_cast<std::int64_t>(bricks_.y) * z);
        std::fill(row + first.x, row + last.x + 1, std::uint8_t{1});
      }
    }
  }
  window_ = ToroidalWindow(window_.size());
}

Result<std::span<const std::uint32_t>> DenseSource::advance() {
  while (next_ == column_sites_.size()) {
    if (column_ + 1 >= columns_.x * columns_.y) return std::span<const std::uint32_t>();
    ++column_;
    begin_column();
  }
  const Stopwatch watch;
  const std::size_t begin = next_;
  const int low = needed_samples(sites_[column_sites_[begin]]).min.z;
  while (next_ < column_sites_.size() && needed_samples(sites_[column_sites_[next_]]).max.z - low < window_.size().z) {
    ++next_;
  }
  std::vector<BrickHash> hashes;
  if (options_.resident != nullptr) {
    hashes = options_.resident->take_hashes();
    skip_resident_bricks(hashes);
    upload(column_reach_);
  } else {
    const glm::ivec3 from(column_reach_.min.x, column_reach_.min.y, low);
    for (const field::IndexBox& entered : window_.move_to(from - base_)) {
      upload({glm::max(entered.min + base_, column_reach_.min), glm::min(entered.max + base_, column_reach_.max)});
    }
  }
  glFinish();  // GL may delay uploads until here
  uploads_.time += watch.elapsed();
  TRY(context_->check("uploading samples"));
  // Drops the hashes if the mapped file was truncated meanwhile: the uploaded samples may differ from the hashed
  // samples.
  if (options_.resident != nullptr && !samples_->lost()) options_.resident->give_back(std::move(hashes));
  return std::span<const std::uint32_t>(column_sites_).subspan(begin, next_ - begin);
}

// Returns the part of a brick (numbered as in `needed_`) that lies in the column.
field::IndexBox DenseSource::brick_box(const glm::ivec3& brick) const {
  const glm::ivec3 low = origin_ + kBrickSamples * (first_brick_ + brick);
  return {glm::max(low, column_reach_.min), glm::min(low + kBrickSamples - 1, column_reach_.max)};
}

// Clears `needed_` for bricks whose current content is already on the device; stores the new hashes of the others.
void DenseSource::skip_resident_bricks(std::vector<BrickHash>& hashes) {
  std::atomic<std::uint64_t> uploaded{0};
  std::atomic<std::uint64_t> kept{0};
  std::atomic<std::uint64_t> kept_samples{0};
  for_each_index(bricks_.z, [&](int z) {
    for (int y = 0; y < bricks_.y; ++y) {
      for (int x = 0; x < bricks_.x; ++x) {
        std::uint8_t& needed =
            needed_[static_cast<std::size_t>(x + bricks_.x * (y + static_cast<std::int64_t>(bricks_.y) * z))];
        if (needed == 0) continue;
        const field::IndexBox box = brick_box({x, y, z});
        const BrickHash now = brick_hash(*samples_, box);
        BrickHash& resident = hashes[options_.resident->hash_index(first_brick_ + glm::ivec3(x, y, z))];
        if (resident == now) {
          needed = 0;
          kept.fetch_add(1, std::memory_order_relaxed);
          kept_samples.fetch_add(volume(glm::ivec3(box.dims())), std::memory_order_relaxed);
        } else {
          resident = now;
          uploaded.fetch_add(1, std::memory_order_relaxed);
        }
      }
    }
  });
  uploads_.bricks += uploaded;
  uploads_.bricks_kept += kept;
  uploads_.samples_kept += kept_samples;
}

// Uploads the needed bricks of a box. Runs of bricks are uploaded at once, and so are successive rows with equal runs.
void DenseSource::upload(const field::IndexBox& entered) {
  if (entered.empty()) return;
  const glm::ivec3 first = (entered.min - origin_) / kBrickSamples - first_brick_;
  const glm::ivec3 last = (entered.max - origin_) / kBrickSamples - first_brick_;
  const auto row = [&](int y, int z) {
    return std::span<const std::uint8_t>(needed_).subspan(
        static_cast<std::size_t>(bricks_.x) *
            (static_cast<std::size_t>(y) + static_cast<std::size_t>(bricks_.y) * static_cast<std::size_t>(z)),
        static_cast<std::size_t>(bricks_.x));
  };
  for (int z = first.z; z <= last.z; ++z) {
    for (int y = first.y; y <= last.y;) {
      int rows = 1;
      while (y + rows <= last.y && std::ranges::equal(row(y, z), row(y + rows, z))) ++rows;
      const auto needed = row(y, z);
      for (int x = first.x; x <= last.x; ++x) {
        if (needed[static_cast<std::size_t>(x)] == 0) continue;
        const int begin = x;
        while (x < last.x && needed[static_cast<std::size_t>(x) + 1] != 0) ++x;
        const field::IndexBox run{brick_box({begin, y, z}).min, brick_box({x, y + rows - 1, z}).max};
        upload_pieces({glm::max(run.min, entered.min), glm::min(run.max, entered.max)});
      }
      y += rows;
    }
  }
}

void DenseSource::upload_pieces(const field::IndexBox& box) {
  // Splits first, before changing any GL state: it allocates memory and may fail.
  const auto pieces = window_.pieces({box.min - base_, box.max - base_});
  glBindTexture(GL_TEXTURE_3D, texture().name());
  glPixelStorei(GL_UNPACK_ROW_LENGTH, samples_->dims.x);
  glPixelStorei(GL_UNPACK_IMAGE_HEIGHT, samples_->dims.y);
  const std::size_t size = field::sample_size(samples_->type);
  const glm::u64vec3 dims(samples_->dims);
  for (const field::IndexBox& piece : pieces) {
    const glm::ivec3 to = window_.texel(piece.min);
    const glm::ivec3 extent(piece.dims());
    const glm::u64vec3 at(piece.min + base_);
    const auto* data = static_cast<const std::byte*>(samples_->data) + size * (at.x + dims.x * (at.y + dims.y * at.z));
    glTexSubImage3D(GL_TEXTURE_3D, 0, to.x, to.y, to.z, extent.x, extent.y, extent.z, format_.format, format_.type,
                    data);
    uploads_.samples += volume(extent);
  }
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glPixelStorei(GL_UNPACK_IMAGE_HEIGHT, 0);
}

void DenseSource::bind(const gl::CountAndCapture& pass, std::span<const std::uint32_t>) {
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_3D, texture().name());
  for (const gl::ShaderProgram* program : pass.programs()) {
    program->set("field_window", 1);
    program->set("window_base", base_);
    program->set("window_size", window_.size());
  }
}

UploadFigures DenseSource::uploads() const {
  UploadFigures figures = uploads_;
  figures.bytes = uploads_.samples * field::sample_size(samples_->type);
  const std::uint64_t all = volume(glm::ivec3(with_apron(region_, apron_, samples_->dims).dims()));
  const std::uint64_t taken = uploads_.samples + uploads_.samples_kept;
  figures.left_out = all > taken ? all - taken : 0;
  return figures;
}

}  // namespace isoextract::gpu
