// Casts rays through a volume with emission and the surfaces: steps 2 to 7 of the model (renderer.hpp).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include <glm/glm.hpp>

#include "render/detail/ray_steps.hpp"

namespace isoextract::render::detail {

// Samples a field of any sample type (CornerReader), batch by batch.
class SlabShader {
 public:
  SlabShader() = default;
  SlabShader(const SlabShader&) = delete;
  SlabShader& operator=(const SlabShader&) = delete;
  virtual ~SlabShader() = default;

  virtual void shade(const SlabRay& ray, SlabBatch& batch) = 0;
};

// Use one per thread. The volume and its emission have their own placements, boxes and bricks. A ray is cut into parts
// where it enters and leaves the boxes; slabs of a part take the samples of those fields that are visible there.
class GlowingRayCaster {
 public:
  // volume.samples and volume.emission are not null.
  GlowingRayCaster(const VolumeView& volume, const SurfaceView& surfaces, const Scene& scene, const Camera& camera,
                   const RenderOptions& options);

  // `within` tells whether the pixel may see the volume or its emission.
  [[nodiscard]] Pixel cast(const glm::dvec3& direction, std::span<const Fragment> fragments, bool within,
                           RenderStatistics& statistics);

 private:
  // The volume or its emission.
  struct Layer {
    explicit Layer(const VolumeView& of);

    // Sets `way` to a part of the ray, and empties the batch.
    void begin_part(const SlabRay& part);

    const VolumeView& view;
    std::unique_ptr<SlabShader> shader;
    glm::dvec3 along{0.0};  // index steps per depth
    double enter = 0;       // depths between which the ray is in the layer's box
    double leave = 0;
    bool inside = false;   // the current part of the ray is in the box
    SlabRay way;           // in that part
    bool visible = false;  // in the current brick
    SlabBatch batch;
  };

  // A slab to composite, with its place in the batch of each layer.
  struct Slab {
    static constexpr std::size_t kNone = SlabBatch::kSlabs;  // the layer has no sample there

    double number = 0;
    std::size_t in_volume = kNone;
    std::size_t in_emission = kNone;
  };

  // The sample of a slab.
  struct Sample {
    double first = 0;  // depths
    double last = 0;
    glm::vec4 entry{0.0F};  // of the volume's transfer function
    double sigma = 0;
    double opacity = 0;    // of the whole slab
    glm::dvec3 glow{0.0};  // light that a unit length emits
  };

  // Passes both layers. Returns the fragments that remain.
  std::span<const Fragment> pass_layers(Ray& ray, const glm::dvec3& direction, std::span<const Fragment> fragments,
                                        RenderStatistics& statistics);
  // These return whether the ray goes on. `before` is the number of slabs in earlier parts.
  bool pass_part(Ray& ray, const SlabRay& part, std::int64_t slabs, std::int64_t before, RayProgress& state);
  bool composite(Ray& ray, std::int64_t before, RayProgress& state);

  // Returns the first slab beyond the bricks that slab k is in, and sets Layer::visible.
  std::int64_t look_ahead(std::int64_t k, std::int64_t slabs);
  void collect(std::int64_t k);
  [[nodiscard]] Sample sample_of(const Slab& slab) const;
  // Composites a slab, which fragments may divide.
  void pass_slab(Ray& ray, const Sample& sample, RayProgress& state) const;
  void pass_piece(Ray& ray, const Sample& sample, double from, double to, double opacity) const;

  const SurfaceView& surfaces_;
  const Scene& scene_;
  const RenderOptions& options_;
  double near_;
  double far_;
  double unit_;
  double step_;
  double per_length_;
  double units_per_depth_ = 0;  // transfer function lengths of this ray
  glm::dvec3 direction_{0.0};   // of this ray
  Layer volume_;
  Layer emission_;
  std::size_t collected_ = 0;
  std::array<Slab, SlabBatch::kSlabs> slabs_;
};

}  // namespace isoextract::render::detail
