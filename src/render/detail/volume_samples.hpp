// Reads the samples of a field as table positions (TransferFunction).
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/sparse_lookup.hpp"
#include "render/scene.hpp"

namespace isoextract::render::detail {

// Shared by all threads; each thread reads it through its own SampleReader or CornerReader.
class VolumeSamples {
 public:
  // Reserves memory for finding blocks. `volume` must outlive the result.
  [[nodiscard]] static Result<VolumeSamples> open(const Volume& volume, const Context& context) {
    VolumeSamples opened(volume);
    if (const auto* sparse = std::get_if<field::SparseSamples>(&volume.field->samples)) {
      const auto nodes = field::SparseLookup::node_origins(*sparse);
      opened.memory_ = TRY(
          context.reserve(nodes.size() * sizeof(field::SparseLookup::Node), volume.field->source + ": block indices"));
      opened.lookup_.emplace(*sparse, nodes);
    }
    return opened;
  }

  [[nodiscard]] const field::ScalarField& field() const { return *volume_->field; }
  [[nodiscard]] const TransferFunction& transfer() const { return volume_->transfer; }
  [[nodiscard]] const field::DenseSamples* dense() const { return std::get_if<field::DenseSamples>(&field().samples); }
  [[nodiscard]] const field::SparseSamples& sparse() const { return std::get<field::SparseSamples>(field().samples); }
  [[nodiscard]] const field::SparseLookup& lookup() const { return *lookup_; }

  [[nodiscard]] float position(double stored) const { return transfer().position(field().scale(stored)); }

 private:
  explicit VolumeSamples(const Volume& volume) : volume_(&volume) {}

  const Volume* volume_;
  std::optional<field::SparseLookup> lookup_;
  Reservation memory_;
};

// Reads samples stored as T. Use one per thread: it caches the block that it read last.
template <class T>
class SampleReader {
 public:
  explicit SampleReader(const VolumeSamples& samples)
      : samples_(samples), dense_(samples.dense()), dims_(dense_ != nullptr ? dense_->dims : glm::ivec3(0)) {}

  // Returns the table position of sample p, which must lie within a dense field.
  [[nodiscard]] float operator()(const glm::ivec3& p) {
    if (dense_ != nullptr) {
      return stored(static_cast<const T*>(dense_->data), p.x + dims_.x * (p.y + dims_.y * p.z));
    }
    if (const glm::ivec3 origin = field::block_origin(p); !known_ || origin != origin_) {
      known_ = true;
      origin_ = origin;
      const std::int32_t place = samples_.lookup().place(origin);
      block_ = place >= 0 ? static_cast<const T*>(samples_.sparse().blocks[static_cast<std::size_t>(place)].values)
                          : nullptr;
      if (block_ == nullptr) constant_ = samples_.position(samples_.lookup().constant_of(place));
    }
    return block_ != nullptr ? stored(block_, field::block_offset(p)) : constant_;
  }

 private:
  [[nodiscard]] float stored(const T* values, std::int64_t at) const {
    return samples_.position(static_cast<double>(values[at]));
  }

  const VolumeSamples& samples_;
  const field::DenseSamples* dense_;
  glm::i64vec3 dims_;
  bool known_ = false;
  glm::ivec3 origin_{0};
  const T* block_ = nullptr;
  float constant_ = 0;
};

}  // namespace isoextract::render::detail
