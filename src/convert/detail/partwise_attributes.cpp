#include "convert/detail/partwise_attributes.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>

#include "base/parallel.hpp"

namespace isoextract::convert {
namespace {

// A thread that makes a part samples so many vertices at a time, and fewer if memory is short.
constexpr std::uint64_t kMostChunkVertices = 8192;
constexpr std::uint64_t kLeastChunkVertices = 256;

std::size_t components_in(const AttributeSource& source) {
  std::size_t components = 0;
  if (const auto* particles = std::get_if<ParticleAttributes>(&source.from)) {
    for (const std::size_t a : particles->attributes) components += particles->particles->attributes[a].components;
    return components;
  }
  for (const VolumeAttribute& attribute : std::get<std::vector<VolumeAttribute>>(source.from)) {
    components += attribute.components.size();
  }
  return components;
}

// Returns whether all values of an attribute are finite. Integers of colors are.
bool has_finite_values(const mesh::Attribute& attribute) {
  if (attribute.type != mesh::ComponentType::f32) return true;
  for (std::size_t at = 0; at < attribute.values.size(); at += sizeof(float)) {
    float value = 0;
    std::memcpy(&value, attribute.values.data() + at, sizeof value);
    if (!std::isfinite(value)) return false;
  }
  return true;
}

edit::ValueRange range_of_both(const edit::ValueRange& a, const edit::ValueRange& b) {
  return {std::min(a[0], b[0]), std::max(a[1], b[1])};
}

// Returns some vertices of a part, with the arrays that the pass asks for, and without triangles.
mesh::MeshPart chunk_of(const mesh::MeshPart& part, std::size_t first, std::size_t count, const mesh::PartPass& pass) {
  mesh::MeshPart chunk;
  chunk.first_vertex = part.first_vertex + first;
  chunk.first_triangle = part.first_triangle;
  if (pass.positions) chunk.positions = part.positions.subspan(first, count);
  if (!part.normals.empty()) chunk.normals = part.normals.subspan(first, count);
  return chunk;
}

}  // namespace

std::uint64_t sampling_bytes(const AttributeSource& source) {
  constexpr std::uint64_t kColorBytes = 8;
  // The attributes that map_attribute() and AttributeSampler copy exist twice.
  return sizeof(glm::vec3) + sizeof(glm::dvec3) + 2 * components_in(source) * sizeof(float) + kColorBytes;
}

std::uint64_t vertices_sampled_at_once(std::uint64_t vertices) {
  return std::min(vertices, static_cast<std::uint64_t>(usable_threads()) * kMostChunkVertices);
}

bool attributes_need_whole_mesh(const ConversionJob& job, const Source& source) {
  const bool has_attributes = !job.source.attributes.empty() || (job.color && job.color->attribute);
  if (!has_attributes) return false;
  if (!source.attributes || !mesh_io::mesh_format_info(job.meshes().format).has_attributes) return true;
  return std::ranges::any_of(source.attributes->missing,
                             [](const MissingAttribute& missing) { return !missing.choice.optional; });
}

PartwiseAttributes::PartwiseAttributes(const StageContext& stage)
    : job_(stage.job),
      source_(*stage.source.attributes),
      context_(stage.context.beside()),
      color_(color_attribute_of(stage.job, stage.source)),
      omits_not_finite_(mesh_io::is_gltf(stage.job.meshes().format)),
      selects_bodies_(stage.job.edits.pieces.drops()),
      measures_first_(components_in(source_) > 0 && (omits_not_finite_ || selects_bodies_ || finds_range())) {
  if (color_ != nullptr) colors_.range = job_.color->range.value_or(edit::ValueRange{});
}

Result<bool> PartwiseAttributes::begin(const mesh::MeshShape& shape) {
  vertices_ = shape.vertices;
  const auto threads = static_cast<std::uint64_t>(usable_threads());
  const std::uint64_t bytes = sampling_bytes(source_);
  // The parts need the rest of the memory.
  const std::uint64_t share = context_.memory().left() / 8 / (threads * bytes);
  const std::uint64_t chunk = std::clamp(share, kLeastChunkVertices, kMostChunkVertices);
  chunk_vertices_ = static_cast<std::size_t>(chunk);
  vertices_at_once_ = static_cast<std::size_t>(std::min(vertices_, threads * chunk));
  auto memory = context_.reserve(vertices_at_once_ * bytes, "attributes of vertices");
  if (!memory) return false;
  auto samplers = AttributeSamplers::make(source_, context_);
  if (!samplers && samplers.error().code == ErrorCode::out_of_memory) return false;
  samplers_ = TRY(std::move(samplers));
  memory_ = std::move(*memory);
  return true;
}

Result<void> PartwiseAttributes::measure(const mesh::MeshPart& part) {
  std::optional<edit::ValueRange> range;
  TRY(for_each_chunk(
      part, chunk_vertices_,
      [&](std::size_t /*first*/, mesh::Mesh& chunk, const std::vector<AttributeResult>& results) -> Result<void> {
        count(results);
        if (!selects_bodies_) look_at(chunk, range);
        return {};
      }));
  keep_range(part.first_vertex, range);
  return {};
}

Result<void> PartwiseAttributes::measure_written(const mesh::MeshPart& part) {
  if (!finds_range() && !omits_not_finite_) return {};
  std::optional<edit::ValueRange> range;
  TRY(for_each_chunk(
      part, chunk_vertices_,
      [&](std::size_t /*first*/, mesh::Mesh& chunk, const std::vector<AttributeResult>& /*results*/) -> Result<void> {
        look_at(chunk, range);
        return {};
      }));
  keep_range(part.first_vertex, range);
  return {};
}

void PartwiseAttributes::finish_measuring() {
  has_counted_ = true;
  if (!finds_range() || ranges_.empty()) return;
  colors_.range = ranges_.begin()->second;
  for (const auto& [vertex, range] : ranges_) colors_.range = range_of_both(colors_.range, range);
}

Result<std::vector<mesh::Attribute>> PartwiseAttributes::attributes() const {
  mesh::Mesh none;
  TRY(add_attributes(source_, none, chunk_context_));
  TRY(complete(none));
  return std::move(none.attributes);
}

std::vector<std::size_t> PartwiseAttributes::not_finite() const {
  std::vector<std::size_t> found;
  for (std::size_t a = 0; a < not_finite_.size(); ++a) {
    if (not_finite_[a]) found.push_back(a);
  }
  return found;
}

void PartwiseAttributes::begin_pass(const mesh::PartPass& pass) {
  pass_ = pass;
  counts_ = !std::exchange(has_counted_, true);
  counts_gray_ = !std::exchange(has_counted_gray_, true);
}

Result<void> PartwiseAttributes::add(const mesh::MeshPart& part, const TakePart& take) {
  if (part.positions.empty()) return take(part);
  // Parts in order come one by one, so all threads work on the same chunk.
  const std::size_t vertices = pass_.in_order ? vertices_at_once_ : chunk_vertices_;
  return for_each_chunk(
      part, vertices,
      [&](std::size_t first, mesh::Mesh& chunk, const std::vector<AttributeResult>& results) -> Result<void> {
        const std::size_t count = chunk.positions.size();
        {
          const ActiveTime::Task task(&time_);
          const edit::ValueColors colors = TRY(complete(chunk));
          if (counts_) this->count(results);
          const std::lock_guard lock(mutex_);
          if (counts_gray_) colors_.not_numbers += colors.not_numbers;
        }
        mesh::MeshPart with_attributes = chunk_of(part, first, count, pass_);
        if (first == 0) with_attributes.triangles = part.triangles;
        with_attributes.attributes = chunk.attributes;
        return take(with_attributes);
      });
}

AttributesOfParts PartwiseAttributes::take_figures() { return {std::move(results_), vertices_, colors_, time_.take()}; }

Result<void> PartwiseAttributes::for_each_chunk(const mesh::MeshPart& part, std::size_t vertices, const UseChunk& use) {
  for (std::size_t first = 0; first < part.positions.size(); first += vertices) {
    const auto positions = part.positions.subspan(first, std::min(vertices, part.positions.size() - first));
    mesh::Mesh chunk;
    std::vector<AttributeResult> results;
    {
      const ActiveTime::Task task(&time_);
      chunk.positions = Buffer<glm::vec3>(positions.size());
      std::ranges::copy(positions, chunk.positions.begin());
      results = TRY(add_attributes(source_, *samplers_, chunk, chunk_context_));
    }
    TRY(use(first, chunk, results));
  }
  return {};
}

void PartwiseAttributes::count(const std::vector<AttributeResult>& results) {
  const std::lock_guard lock(mutex_);
  if (results_.empty()) {
    results_ = results;
    return;
  }
  for (std::size_t a = 0; a < results.size(); ++a) results_[a].add(results[a]);
}

void PartwiseAttributes::look_at(mesh::Mesh& chunk, std::optional<edit::ValueRange>& range) {
  const ActiveTime::Task task(&time_);
  if (finds_range()) {
    const auto found = edit::range_of_attribute(chunk, *color_);
    if (found) range = range ? range_of_both(*range, *found) : *found;
  }
  if (!omits_not_finite_) return;
  if (color_ != nullptr) drop_unwritten(job_, chunk);  // the colors, which come last, are always finite
  transform_attributes(chunk, source_.kinds, source_.output_from_world);
  for (std::size_t a = 0; a < chunk.attributes.size(); ++a) {
    if (has_finite_values(chunk.attributes[a])) continue;
    const std::lock_guard lock(mutex_);
    not_finite_.resize(std::max(not_finite_.size(), a + 1));
    not_finite_[a] = true;
  }
}

void PartwiseAttributes::keep_range(std::uint64_t first_vertex, const std::optional<edit::ValueRange>& range) {
  if (!range) return;
  const std::lock_guard lock(mutex_);
  ranges_.emplace(first_vertex, *range);
}

Result<edit::ValueColors> PartwiseAttributes::complete(mesh::Mesh& chunk) const {
  edit::ValueColors colors;
  if (color_ != nullptr) {
    colors = TRY(color_vertices(chunk, job_, colors_.range, chunk_context_));
    drop_unwritten(job_, chunk);
  }
  transform_attributes(chunk, source_.kinds, source_.output_from_world);
  return colors;
}

}  // namespace isoextract::convert
