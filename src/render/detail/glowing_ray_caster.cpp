#include "render/detail/glowing_ray_caster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <type_traits>
#include <utility>

#include "render/detail/corner_reader.hpp"

namespace isoextract::render::detail {
namespace {

template <class T>
class TypedSlabShader final : public SlabShader {
 public:
  explicit TypedSlabShader(const VolumeSamples& samples) : corners_(samples) {}
  void shade(const SlabRay& ray, SlabBatch& batch) override { corners_.shade(ray, batch); }

 private:
  CornerReader<T> corners_;
};

std::unique_ptr<SlabShader> make_shader(const VolumeSamples& samples) {
  std::unique_ptr<SlabShader> made;
  field::visit_sample_type(samples.field().type(), [&]<class T>(std::type_identity<T>) {
    made = std::make_unique<TypedSlabShader<T>>(samples);
  });
  return made;
}

// Returns (1 - exp(-tau)) / tau: the share of its own light that leaves a slab. `opacity` is 1 - exp(-tau).
double leaving_share(double tau, double opacity) {
  constexpr double kSmall = 1e-5;  // below it the series is exact, and the quotient loses digits
  return tau > kSmall ? opacity / tau : 1 - tau / 2;
}

// Depths of a part of a ray; leave <= enter: none.
struct Part {
  double enter = 0;
  double leave = 0;

  [[nodiscard]] bool empty() const { return !(leave > enter); }
  [[nodiscard]] bool holds(const Part& part) const { return !empty() && enter <= part.enter && part.leave <= leave; }
};

// Cuts the ray where it enters and leaves two boxes. The middle part lies in both boxes, or between them.
std::array<Part, 3> parts_of(const Part& a, const Part& b) {
  if (a.empty() || b.empty()) return {a.empty() ? b : a, Part{}, Part{}};
  const auto [first, second] = std::minmax(std::max(a.enter, b.enter), std::min(a.leave, b.leave));
  return {Part{std::min(a.enter, b.enter), first}, Part{first, second}, Part{second, std::max(a.leave, b.leave)}};
}

}  // namespace

GlowingRayCaster::Layer::Layer(const VolumeView& of) : view(of), shader(make_shader(*of.samples)) {}

void GlowingRayCaster::Layer::begin_part(const SlabRay& part) {
  way = part;
  way.eye = view.eye;
  way.along = along;
  way.first = view.box.min;
  way.greatest = view.box.max - 1.0;
  batch.size = 0;
}

GlowingRayCaster::GlowingRayCaster(const VolumeView& volume, const SurfaceView& surfaces, const Scene& scene,
                                   const Camera& camera, const RenderOptions& options)
    : surfaces_(surfaces),
      scene_(scene),
      options_(options),
      near_(camera.near_depth / camera.unit()),
      far_(camera.far_depth / camera.unit()),
      unit_(camera.unit()),
      step_(volume.step),
      per_length_(volume.per_length),
      volume_(volume),
      emission_(*volume.emission) {}

Pixel GlowingRayCaster::cast(const glm::dvec3& direction, std::span<const Fragment> fragments, bool within,
                             RenderStatistics& statistics) {
  Ray ray(options_, unit_);
  direction_ = direction;
  if (within) fragments = pass_layers(ray, direction, fragments, statistics);
  for (const Fragment& fragment : fragments) {
    if (ray.ended()) break;
    ray.meet(surfaces_.shade(fragment.triangle, direction), fragment.depth);
  }
  return ray.end(scene_.background);
}

std::span<const Fragment> GlowingRayCaster::pass_layers(Ray& ray, const glm::dvec3& direction,
                                                        std::span<const Fragment> fragments,
                                                        RenderStatistics& statistics) {
  for (Layer* layer : {&volume_, &emission_}) {
    layer->along = layer->view.index_of_view * direction;
    std::tie(layer->enter, layer->leave) = depths_in_box(layer->view, layer->along, near_, far_);
  }
  const Part in_volume{volume_.enter, volume_.leave};
  const Part in_emission{emission_.enter, emission_.leave};
  if (in_volume.empty() && in_emission.empty()) return fragments;
  ++statistics.rays;
  const double length = glm::length(direction) * unit_;  // world units per depth
  units_per_depth_ = length * per_length_;
  SlabRay way;
  way.step = step_ / length;
  way.length = length;
  way.per_length = per_length_;

  const std::array<Part, 3> parts = parts_of(in_volume, in_emission);
  std::array<std::int64_t, 3> counts{};
  for (std::size_t n = 0; n < parts.size(); ++n) {
    const Part& part = parts[n];
    if (part.empty() || !(in_volume.holds(part) || in_emission.holds(part))) continue;
    counts[n] = count_slabs(part.enter, part.leave, way.step);
  }
  const std::int64_t all = counts[0] + counts[1] + counts[2];
  RayProgress state{fragments, all};
  std::int64_t before = 0;
  for (std::size_t n = 0; n < parts.size(); before += counts[n++]) {
    if (counts[n] == 0) continue;
    way.enter = parts[n].enter;
    way.leave = parts[n].leave;
    way.slabs = static_cast<double>(counts[n]);
    volume_.inside = in_volume.holds(parts[n]);
    emission_.inside = in_emission.holds(parts[n]);
    if (!pass_part(ray, way, counts[n], before, state)) break;
  }
  statistics.samples += static_cast<std::uint64_t>(state.samples);
  statistics.samples_skipped += static_cast<std::uint64_t>(state.passed - state.samples);
  statistics.samples_terminated += static_cast<std::uint64_t>(all - state.passed);
  return state.fragments;
}

bool GlowingRayCaster::pass_part(Ray& ray, const SlabRay& part, std::int64_t slabs, std::int64_t before,
                                 RayProgress& state) {
  volume_.begin_part(part);
  emission_.begin_part(part);
  collected_ = 0;
  const auto meet = [&](const Fragment& fragment) {
    ray.meet(surfaces_.shade(fragment.triangle, direction_), fragment.depth);
  };
  for (std::int64_t k = 0; k < slabs;) {
    const double first = part.enter + static_cast<double>(k) * part.step;
    if (state.next_fragment_depth() <= first) {
      if (!composite(ray, before, state)) return false;
      if (!state.add_fragments_until(first, ray, meet)) {
        state.passed = before + k;
        return false;
      }
    }
    const std::int64_t next = look_ahead(k, slabs);
    if (!volume_.visible && !emission_.visible) {
      k = next;
      continue;
    }
    while (k < next) {
      collect(k++);
      if (collected_ == slabs_.size() && !composite(ray, before, state)) return false;
    }
  }
  return composite(ray, before, state);
}

std::int64_t GlowingRayCaster::look_ahead(std::int64_t k, std::int64_t slabs) {
  std::int64_t next = slabs;
  for (Layer* layer : {&volume_, &emission_}) {
    layer->visible = false;
    if (!layer->inside) continue;
    const glm::ivec3 brick = cell_at(layer->way, k) >> 3;
    next = std::min(next, next_slab(brick, layer->way, k, slabs));
    layer->visible = layer->view.bricks == nullptr || layer->view.bricks->is_visible(brick);
  }
  return next;
}

void GlowingRayCaster::collect(std::int64_t k) {
  Slab& slab = slabs_[collected_++];
  slab = {static_cast<double>(k)};
  const auto add_to = [&](Layer& layer, std::size_t& place) {
    if (!layer.visible) return;
    place = layer.batch.size++;
    layer.batch.number[place] = slab.number;
  };
  add_to(volume_, slab.in_volume);
  add_to(emission_, slab.in_emission);
}

GlowingRayCaster::Sample GlowingRayCaster::sample_of(const Slab& slab) const {
  Sample sample;
  if (slab.in_emission != Slab::kNone) {
    const SlabBatch& batch = emission_.batch;
    sample.first = batch.first[slab.in_emission];
    sample.last = batch.last[slab.in_emission];
    if (batch.sigma[slab.in_emission] > 0) sample.glow = glm::dvec3(batch.entry[slab.in_emission]);
  }
  if (slab.in_volume != Slab::kNone) {
    const SlabBatch& batch = volume_.batch;
    sample.first = batch.first[slab.in_volume];
    sample.last = batch.last[slab.in_volume];
    sample.entry = batch.entry[slab.in_volume];
    sample.sigma = batch.sigma[slab.in_volume];
    sample.opacity = batch.opacity[slab.in_volume];
  }
  return sample;
}

bool GlowingRayCaster::composite(Ray& ray, std::int64_t before, RayProgress& state) {
  const std::size_t count = std::exchange(collected_, 0);
  if (count == 0) return true;
  for (Layer* layer : {&volume_, &emission_}) {
    if (layer->batch.size == 0) continue;
    place(layer->way, layer->batch);
    layer->shader->shade(layer->way, layer->batch);
    layer->batch.size = 0;
  }
  const auto meet = [&](const Fragment& fragment) {
    ray.meet(surfaces_.shade(fragment.triangle, direction_), fragment.depth);
  };
  for (std::size_t i = 0; i < count; ++i) {
    const auto number = static_cast<std::int64_t>(slabs_[i].number);
    const Sample sample = sample_of(slabs_[i]);
    if (state.next_fragment_depth() <= sample.first && !state.add_fragments_until(sample.first, ray, meet)) {
      state.passed = before + number;
      return false;
    }
    ++state.samples;
    pass_slab(ray, sample, state);
    if (ray.ended()) {
      state.passed = before + number + 1;
      return false;
    }
  }
  return true;
}

void GlowingRayCaster::pass_slab(Ray& ray, const Sample& sample, RayProgress& state) const {
  const bool shines = sample.glow != glm::dvec3(0);
  if (!(sample.sigma > 0) && !shines) return;
  if (!(state.next_fragment_depth() < sample.last)) {
    pass_piece(ray, sample, sample.first, sample.last, sample.opacity);
    return;
  }
  const auto opacity = [&](double from, double to) {
    return 1 - std::exp(-sample.sigma * units_per_depth_ * (to - from));
  };
  double from = sample.first;
  while (!ray.ended() && state.next_fragment_depth() < sample.last) {
    const double to = state.next_fragment_depth();
    if (to > from) pass_piece(ray, sample, from, to, opacity(from, to));
    if (ray.ended()) return;
    const Fragment& fragment = state.fragments.front();
    ray.meet(surfaces_.shade(fragment.triangle, direction_), fragment.depth);
    state.fragments = state.fragments.subspan(1);
    from = std::max(from, to);
  }
  if (!ray.ended()) pass_piece(ray, sample, from, sample.last, opacity(from, sample.last));
}

void GlowingRayCaster::pass_piece(Ray& ray, const Sample& sample, double from, double to, double opacity) const {
  const double units = units_per_depth_ * (to - from);
  ray.glow(sample.glow * (units * leaving_share(sample.sigma * units, opacity)));
  if (sample.sigma > 0) ray.pass(sample.entry, opacity, sample.first, sample.last);
}

}  // namespace isoextract::render::detail
