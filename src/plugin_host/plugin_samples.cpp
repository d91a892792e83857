#include "plugin_host/plugin_samples.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <new>
#include <tuple>
#include <utility>

#include "base/allocation_error.hpp"

namespace isoextract::plugin_host {
namespace {

struct TypePair {
  std::int32_t plugin;
  field::SampleType host;
};
constexpr std::array kSampleTypes{
    TypePair{ISOEXTRACT_U8, field::SampleType::u8},   TypePair{ISOEXTRACT_I8, field::SampleType::i8},
    TypePair{ISOEXTRACT_U16, field::SampleType::u16}, TypePair{ISOEXTRACT_I16, field::SampleType::i16},
    TypePair{ISOEXTRACT_U32, field::SampleType::u32}, TypePair{ISOEXTRACT_I32, field::SampleType::i32},
    TypePair{ISOEXTRACT_F16, field::SampleType::f16}, TypePair{ISOEXTRACT_F32, field::SampleType::f32},
    TypePair{ISOEXTRACT_F64, field::SampleType::f64}};

glm::ivec3 vector_of(const std::int32_t* numbers) { return {numbers[0], numbers[1], numbers[2]}; }

bool is_within_limits(const glm::ivec3& origin, int size) {
  for (int axis = 0; axis < 3; ++axis) {
    if (origin[axis] < -field::kMaxSparseIndex || origin[axis] > field::kMaxSparseIndex - size) return false;
    if (origin[axis] % size != 0) return false;
  }
  return true;
}

auto order_of(const glm::ivec3& v) { return std::tuple(v.x, v.y, v.z); }

}  // namespace

std::optional<field::SampleType> sample_type_of(std::int32_t type) {
  const auto found = std::ranges::find(kSampleTypes, type, &TypePair::plugin);
  return found == kSampleTypes.end() ? std::nullopt : std::optional(found->host);
}

std::int32_t plugin_type_of(field::SampleType type) {
  return std::ranges::find(kSampleTypes, type, &TypePair::host)->plugin;
}

field::Affine affine_of(const double* index_to_world) {
  field::Affine affine;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) affine.linear[column][row] = index_to_world[4 * row + column];
    affine.offset[row] = index_to_world[4 * row + 3];
  }
  return affine;
}

std::array<double, 12> plugin_rows_of(const field::Affine& affine) {
  std::array<double, 12> rows{};
  for (int row = 0; row < 3; ++row) {
    const auto at = std::size_t{4} * static_cast<std::size_t>(row);
    for (int column = 0; column < 3; ++column) rows[at + static_cast<std::size_t>(column)] = affine.linear[column][row];
    rows[at + 3] = affine.offset[row];
  }
  return rows;
}

PluginMemory::PluginMemory(const Context& context, std::string what)
    : context_(context),
      what_(std::move(what)),
      host_{this,
            [](void* self, std::uint64_t bytes) { return static_cast<PluginMemory*>(self)->reserve(bytes) ? 0 : 1; },
            [](void* self, std::uint64_t bytes) { static_cast<PluginMemory*>(self)->release(bytes); },
            [](void* self, std::uint64_t bytes) { return static_cast<PluginMemory*>(self)->allocate(bytes); },
            [](void* self) { return static_cast<const PluginMemory*>(self)->context_.cancelled() ? 1 : 0; }} {}

bool PluginMemory::reserve(std::uint64_t bytes) {
  const std::scoped_lock lock(mutex_);
  auto part = context_.reserve(bytes, what_);
  if (part) {
    parts_.push_back(std::move(*part));
  } else {
    refusal_ = std::move(part.error());
  }
  return !refusal_;
}

bool PluginMemory::hold(std::uint64_t bytes) {
  const std::scoped_lock lock(mutex_);
  auto part = context_.reserve(bytes, what_);
  if (part) {
    held_.push_back(std::move(*part));
  } else {
    refusal_ = std::move(part.error());
  }
  return !refusal_;
}

void* PluginMemory::allocate(std::uint64_t bytes) {
  if (!hold(bytes)) return nullptr;
  const std::scoped_lock lock(mutex_);
  try {
    blocks_.emplace_back(static_cast<std::size_t>(bytes));
  } catch (const std::bad_alloc&) {
    refusal_ = allocation_error(what_ + ": not enough memory");
    return nullptr;
  }
  return blocks_.back().data();
}

void PluginMemory::release(std::uint64_t bytes) {
  const std::scoped_lock lock(mutex_);
  while (bytes > 0 && !parts_.empty()) {
    const std::uint64_t less = std::min(bytes, parts_.back().bytes());
    parts_.back().shrink(parts_.back().bytes() - less);
    if (parts_.back().bytes() == 0) parts_.pop_back();
    bytes -= less;
  }
}

Error PluginMemory::refusal_or(Error otherwise) const {
  if (auto going_on = context_.check(); !going_on) return going_on.error();
  const std::scoped_lock lock(mutex_);
  return refusal_.value_or(std::move(otherwise));
}

tl::expected<field::SparseSamples, std::string> sparse_samples_of(const isoextract_sparse_samples& given,
                                                                  std::shared_ptr<const void> owner) {
  const auto wrong = [](const char* what) { return tl::unexpected<std::string>(what); };
  field::SparseSamples samples;
  const auto type = sample_type_of(given.sample_type);
  if (!type) return wrong("samples of an unknown type");
  samples.type = *type;
  samples.background = given.background;
  if ((given.blocks == nullptr && given.block_count > 0) || (given.tiles == nullptr && given.tile_count > 0)) {
    return wrong("a null list of blocks or tiles");
  }
  samples.blocks.reserve(given.block_count);
  for (std::size_t i = 0; i < given.block_count; ++i) {
    const isoextract_sparse_block& block = given.blocks[i];
    const glm::ivec3 origin = vector_of(block.origin);
    if (!is_within_limits(origin, field::SparseBlock::kSize))
      return wrong("a block whose origin is not a multiple of 8, or out of range");
    if (i > 0 && order_of(samples.blocks.back().origin) >= order_of(origin))
      return wrong("blocks that are not in order");
    if (block.values == nullptr || reinterpret_cast<std::uintptr_t>(block.values) % field::sample_size(*type) != 0) {
      return wrong("a block without values, or with values that are not aligned for their type");
    }
    samples.blocks.push_back({origin, block.values});
  }
  samples.tiles.reserve(given.tile_count);
  for (std::size_t i = 0; i < given.tile_count; ++i) {
    const isoextract_sparse_tile& tile = given.tiles[i];
    const glm::ivec3 origin = vector_of(tile.origin);
    const bool has_size =
        tile.size >= field::SparseBlock::kSize && std::has_single_bit(static_cast<unsigned>(tile.size));
    if (!has_size || !is_within_limits(origin, tile.size)) return wrong("a tile with an invalid size or origin");
    const bool both_nan = std::isnan(tile.value) && std::isnan(given.background);
    if (tile.value == given.background || both_nan) continue;
    samples.tiles.push_back({origin, tile.size, tile.value});
  }
  samples.active_box = {vector_of(given.active_min), vector_of(given.active_max)};
  samples.active_voxels = given.active_voxels;
  if (samples.active_box.empty()) samples.active_box = {};
  samples.owner = std::move(owner);
  return samples;
}

std::unique_ptr<const PluginSparse> plugin_sparse_of(const field::SparseSamples& samples) {
  auto given = std::make_unique<PluginSparse>();
  given->blocks.reserve(samples.blocks.size());
  for (const field::SparseBlock& block : samples.blocks) {
    given->blocks.push_back({{block.origin.x, block.origin.y, block.origin.z}, block.values});
  }
  given->tiles.reserve(samples.tiles.size());
  for (const field::SparseTile& tile : samples.tiles) {
    given->tiles.push_back({{tile.origin.x, tile.origin.y, tile.origin.z}, tile.size, tile.value});
  }
  given->samples = {plugin_type_of(samples.type),
                    given->blocks.data(),
                    given->blocks.size(),
                    given->tiles.data(),
                    given->tiles.size(),
                    samples.background,
                    {samples.active_box.min.x, samples.active_box.min.y, samples.active_box.min.z},
                    {samples.active_box.max.x, samples.active_box.max.y, samples.active_box.max.z},
                    samples.active_voxels};
  return given;
}

}  // namespace isoextract::plugin_host
