#include "convert/attribute_source.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/parallel.hpp"
#include "base/printable.hpp"
#include "base/reserved_buffer.hpp"
#include "base/stopwatch.hpp"
#include "convert/stages/surface_stages.hpp"
#include "field/point_samples.hpp"
#include "mesh/attribute_map.hpp"
#include "points/attribute_sampling.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::convert {

Result<std::shared_ptr<ReservedBuffer<glm::dvec3>>> world_positions(const field::Affine& world_from_output,
                                                                    const mesh::Mesh& mesh, const Context& context) {
  auto places = make_reserved_buffer<glm::dvec3>(mesh.positions.size(), context, "positions of vertices");
  if (!places) return places;
  for_each_range(mesh.positions.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      (*places)->values[v] = world_from_output(mesh.position(v));
    }
  });
  return places;
}

namespace {

mesh::Attribute float_attribute(const std::string& name, std::size_t components, std::size_t vertices) {
  mesh::Attribute made;
  made.name = name;
  made.components = components;
  made.values = Buffer<std::byte>(components * vertices * sizeof(float));
  return made;
}

using Records = std::vector<AttributeResult>;

void take_attributes(std::vector<mesh::Attribute>&& added, Reservation memory, mesh::Mesh& mesh) {
  std::ranges::move(added, std::back_inserter(mesh.attributes));
  mesh.memory.take(std::move(memory));
}

// Returns how many vertices have a component that is not finite.
std::uint64_t count_not_finite(std::span<const float> values, std::size_t components) {
  std::uint64_t count = 0;
  for (std::size_t first = 0; first < values.size(); first += components) {
    if (!std::ranges::all_of(values.subspan(first, components), [](float v) { return std::isfinite(v); })) ++count;
  }
  return count;
}

// `samplers` may be null, here and below.
Result<Records> add_of_particles(const ParticleAttributes& source, const AttributeSamplers* samplers,
                                 std::span<const glm::dvec3> places, mesh::Mesh& mesh, const Context& context) {
  if (source.attributes.empty()) return Records();
  if (places.empty()) {  // without vertices there may be no particles, and then no radius
    for (std::size_t a = 0; a < source.attributes.size(); ++a) {
      const std::size_t components = source.particles->attributes[source.attributes[a]].components;
      mesh.attributes.push_back(float_attribute(source.choices[a].name, components, 0));
    }
    return Records();
  }
  const auto sampled =
      TRY(samplers != nullptr ? samplers->of_particles()->sample(places, context)
                              : points::sample_attributes(*source.particles, source.attributes, places, source.radius,
                                                          source.smoothing_length, context));
  std::uint64_t bytes = 0;
  for (const points::SampledAttribute& attribute : sampled.attributes) bytes += attribute.values.size_bytes();
  auto memory = TRY(context.reserve(bytes, "attributes of vertices"));
  Records records;
  std::vector<mesh::Attribute> added;
  for (std::size_t a = 0; a < sampled.attributes.size(); ++a) {
    const points::SampledAttribute& attribute = sampled.attributes[a];
    mesh::Attribute& made =
        added.emplace_back(float_attribute(source.choices[a].name, attribute.components, places.size()));
    if (!made.values.empty()) std::memcpy(made.values.data(), attribute.values.data(), attribute.values.size_bytes());
    AttributeResult& record = records.emplace_back();
    record.name = made.name;
    record.source = fmt::format("{}: {}", printable(source.particles->label), printable(source.choices[a].from));
    record.components = made.components;
    record.vertices_beyond_kernels = sampled.vertices_beyond_kernels;
    record.counts = {{.not_finite = count_not_finite(attribute.values.span(), attribute.components)}};
  }
  take_attributes(std::move(added), std::move(memory), mesh);
  return records;
}

AttributeKind kind_of(const AttributeSource& source, const std::string& name) {
  const auto found = std::ranges::find(source.kinds, name, &NamedKind::name);
  return found == source.kinds.end() ? AttributeKind::scalar : found->kind;
}

Result<Records> add_of_volumes(const AttributeSource& source, const AttributeSamplers* samplers,
                               std::span<const glm::dvec3> places, mesh::Mesh& mesh, const Context& context) {
  const auto& attributes = std::get<std::vector<VolumeAttribute>>(source.from);
  std::size_t components = 0;
  for (const VolumeAttribute& attribute : attributes) components += attribute.components.size();
  auto memory = TRY(context.reserve(components * places.size() * sizeof(float), "attributes of vertices"));
  Records records;
  std::vector<mesh::Attribute> added;
  for (std::size_t a = 0; a < attributes.size(); ++a) {
    const VolumeAttribute& attribute = attributes[a];
    const std::size_t count = attribute.components.size();
    mesh::Attribute& made = added.emplace_back(float_attribute(attribute.choice.name, count, places.size()));
    const std::span<float> values(reinterpret_cast<float*>(made.values.data()), count * places.size());
    AttributeResult& record = records.emplace_back();
    record.name = made.name;
    record.source = attribute.components.front().name;
    record.components = count;
    for (std::size_t c = 0; c < count && !places.empty(); ++c) {
      const field::ScalarField& field = attribute.components[c];
      const auto to = values.subspan(c);
      record.counts.push_back(TRY(samplers != nullptr ? samplers->of_volume(a, c).sample(places, to, count, context)
                                                      : field::sample_points(field, places, to, count, context)));
      TRY(volume_io::check_mapping_intact(field));
    }
    if (!attribute.in_voxels) continue;
    const field::Affine& world_from_voxels = attribute.components.front().index_to_world;
    map_attribute(made, kind_of(source, made.name), world_from_voxels.linear, world_from_voxels.offset);
  }
  take_attributes(std::move(added), std::move(memory), mesh);
  return records;
}

// Finds the kind of one attribute, and adds a note if a three-component attribute has no known kind.
Result<void> add_kind(const AttributeChoice& choice, std::size_t components, std::optional<AttributeKind> stated,
                      AttributeSource& source) {
  const auto kind = TRY(find_kind(choice, components, stated));
  source.kinds.push_back({choice.name, kind.value_or(AttributeKind::scalar)});
  if (kind || components != 3 || !choice.written || source.output_from_world.linear == glm::dmat3(1)) return {};
  source.kind_notes.push_back(
      {NoteId::attribute_kind,
       fmt::format("the kind of the three-component attribute '{}' is unknown: its values do not rotate or scale with "
                   "the mesh, as vectors do",
                   printable(choice.name))});
  return {};
}

}  // namespace

Result<void> set_attribute_maps(AttributeSource& source, const field::Affine& world_from_output,
                                const field::Affine& output_from_world) {
  source.world_from_output = world_from_output;
  source.output_from_world = output_from_world;
  if (const auto* particles = std::get_if<ParticleAttributes>(&source.from)) {
    for (std::size_t a = 0; a < particles->choices.size(); ++a) {
      const points::ParticleAttribute& attribute = particles->particles->attributes[particles->attributes[a]];
      auto added = add_kind(particles->choices[a], attribute.components, attribute.kind, source);
      if (!added) return added;
    }
    return {};
  }
  for (const VolumeAttribute& attribute : std::get<std::vector<VolumeAttribute>>(source.from)) {
    auto added = add_kind(attribute.choice, attribute.components.size(), attribute.stated_kind, source);
    if (!added) return added;
  }
  return {};
}

std::vector<NamedKind> written_kinds(const AttributeSource& source) {
  std::vector<NamedKind> kinds = source.kinds;
  const auto drop = [&](const AttributeChoice& choice) {
    if (!choice.written) std::erase_if(kinds, [&](const NamedKind& named) { return named.name == choice.name; });
  };
  if (const auto* particles = std::get_if<ParticleAttributes>(&source.from)) {
    std::ranges::for_each(particles->choices, drop);
  } else {
    std::ranges::for_each(std::get<std::vector<VolumeAttribute>>(source.from), drop, &VolumeAttribute::choice);
  }
  return kinds;
}

namespace {

// Returns whether values of this kind change with the placement of the mesh: a mere move changes points only.
bool changes_values(const field::Affine& placement, AttributeKind kind) {
  if (kind == AttributeKind::point) return placement != field::Affine();
  return is_transformed_with_mesh(kind) && placement.linear != glm::dmat3(1);
}

Result<Records> add_with(const AttributeSource& source, const AttributeSamplers* samplers, mesh::Mesh& mesh,
                         const Context& context) {
  const auto places = TRY(world_positions(source.world_from_output, mesh, context));
  const std::span<const glm::dvec3> at = places->values.span();
  const auto* particles = std::get_if<ParticleAttributes>(&source.from);
  auto records = particles != nullptr ? add_of_particles(*particles, samplers, at, mesh, context)
                                      : add_of_volumes(source, samplers, at, mesh, context);
  if (!records) return records;
  for (AttributeResult& record : *records) {
    record.vertices = at.size();
    record.kind = kind_of(source, record.name);
    record.changed = record.components == 3 && changes_values(source.output_from_world, record.kind);
  }
  return records;
}

}  // namespace

std::uint64_t AttributeResult::outside() const {
  std::uint64_t most = 0;
  for (const field::PointCounts& one : counts) most = std::max(most, one.outside);
  return most;
}

std::uint64_t AttributeResult::not_finite() const {
  std::uint64_t most = 0;
  for (const field::PointCounts& one : counts) most = std::max(most, one.not_finite);
  return most;
}

void AttributeResult::add(const AttributeResult& other) {
  vertices += other.vertices;
  vertices_beyond_kernels += other.vertices_beyond_kernels;
  for (std::size_t c = 0; c < counts.size(); ++c) {
    counts[c].outside += other.counts[c].outside;
    counts[c].not_finite += other.counts[c].not_finite;
  }
}

Result<AttributeSamplers> AttributeSamplers::make(const AttributeSource& source, const Context& context) {
  AttributeSamplers samplers;
  if (const auto* particles = std::get_if<ParticleAttributes>(&source.from)) {
    if (particles->attributes.empty()) return samplers;
    samplers.particles_ = TRY(points::AttributeSampler::make(*particles->particles, particles->attributes,
                                                             particles->radius, particles->smoothing_length, context));
    return samplers;
  }
  for (const VolumeAttribute& attribute : std::get<std::vector<VolumeAttribute>>(source.from)) {
    std::vector<field::PointSampler>& all = samplers.volumes_.emplace_back();
    for (const field::ScalarField& field : attribute.components) {
      all.push_back(TRY(field::PointSampler::make(field, context)));
    }
  }
  return samplers;
}

Result<std::vector<AttributeResult>> add_attributes(const AttributeSource& source, mesh::Mesh& mesh,
                                                    const Context& context) {
  return add_with(source, nullptr, mesh, context);
}

Result<std::vector<AttributeResult>> add_attributes(const AttributeSource& source, const AttributeSamplers& samplers,
                                                    mesh::Mesh& mesh, const Context& context) {
  return add_with(source, &samplers, mesh, context);
}

Result<StageReport> sample_vertex_attributes(Surface& surface, const StageContext& stage) {
  const auto& attributes = stage.source.attributes;
  if (!attributes) return StageReport();
  StageReport report = stage.report_on(StageName::attributes, surface);
  for (const MissingAttribute& missing : attributes->missing) {
    if (missing.choice.optional) continue;
    if (surface.triangles() > 0) return tl::unexpected(missing.error);
    report.notes.push_back(
        {NoteId::no_surface, fmt::format("{}: the surface is empty, and the input has no attribute '{}'",
                                         report.subject, printable(missing.choice.name))});
  }
  const Stopwatch watch;
  std::vector<AttributeResult> carried;
  std::uint64_t vertices = surface.vertices();
  if (surface.taken) {
    carried = surface.attributes->results;
    vertices = surface.attributes->vertices;
    report.time = surface.attributes->time;
  } else {
    carried = TRY(add_attributes(*attributes, surface.mesh, stage.context));
    report.time = watch.elapsed();
  }
  report.did = "attributes sampled";
  report.details.push_back(counted(vertices, "vertex", "vertices"));
  for (const AttributeResult& one : carried) {
    report.entries.push_back({{Key::name, one.name},
                              {Key::source, one.source},
                              {Key::components, one.components},
                              {Key::kind, word_of(one.kind)},
                              {Key::changed, one.changed},
                              {Key::vertices, one.vertices},
                              {Key::outside, one.outside()},
                              {Key::not_finite, one.not_finite()},
                              {Key::out_of_reach, one.vertices_beyond_kernels}});
    const std::string start = report.subject + ": ";
    if (one.outside() > 0) {
      report.notes.push_back(
          {NoteId::attribute_outside,
           fmt::format(
               "{}{} of {} vertices lie outside {}; their '{}' is the value at the nearest point of its boundary",
               start, one.outside(), one.vertices, one.source, printable(one.name))});
    }
    if (one.not_finite() > 0) {
      report.notes.push_back(
          {NoteId::nan_attribute,
           fmt::format("{}the attribute '{}' is not finite at {} of {} vertices, because {} has non-finite values",
                       start, printable(one.name), one.not_finite(), one.vertices, one.source)});
    }
  }
  // All attributes of particles have the same reach, so the first one's count stands for all.
  if (!carried.empty() && carried.front().vertices_beyond_kernels > 0) {
    report.notes.push_back(
        {NoteId::attribute_of_nearest,
         fmt::format(
             "{}: {} of {} vertices have the attributes of the nearest particle, because no particle's kernel reaches "
             "these vertices",
             report.subject, carried.front().vertices_beyond_kernels, vertices)});
  }
  return report;
}

}  // namespace isoextract::convert
