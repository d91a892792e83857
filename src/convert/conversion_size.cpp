#include "convert/conversion_size.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/context.hpp"
#include "base/parallel.hpp"
#include "convert/detail/error_memory.hpp"
#include "convert/detail/output_meshes.hpp"
#include "convert/detail/packing_memory.hpp"
#include "convert/detail/particle_file.hpp"
#include "convert/detail/partwise_output.hpp"
#include "convert/detail/several_grids.hpp"
#include "convert/source.hpp"
#include "convert/stages/mesh_hollow.hpp"
#include "convert/stages/mesh_simplify.hpp"
#include "convert/stages/surface_stages.hpp"
#include "edit/bounded_simplify.hpp"
#include "edit/partwise_bodies.hpp"
#include "extract/dense_input.hpp"
#include "extract/inner_wall.hpp"
#include "extract/mapped_slices.hpp"
#include "field/resample.hpp"
#include "field/sparse_lookup.hpp"
#include "field/surface_estimate.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::convert {
namespace {

std::uint64_t mesh_bytes(std::uint64_t vertices, bool has_normals) {
  return vertices * (has_normals ? 2 : 1) * sizeof(glm::vec3) + 2 * vertices * sizeof(glm::uvec3);
}

std::uint64_t bytes_without_mesh(const ConversionSize& size) {
  constexpr std::uint64_t kPlaceBytes = 400;  // lookup of a block position and its vertex numbers
  constexpr std::uint64_t kCapBytes = 48;     // of the growing lists of a vertex of the cap and its triangles
  return kProgramBytes + kConversionBytes + size.resident_bytes + size.mark_bytes + size.lookup_bytes +
         size.places * kPlaceBytes + size.cap_vertices * kCapBytes;
}

// Returns the bytes of attribute values and a color for each vertex.
std::uint64_t attribute_value_bytes(const Source& source) {
  if (!source.attributes) return 0;
  std::size_t components = 0;
  if (const auto* particles = std::get_if<ParticleAttributes>(&source.attributes->from)) {
    for (const std::size_t a : particles->attributes) components += particles->particles->attributes[a].components;
  } else {
    for (const auto& attribute : std::get<std::vector<VolumeAttribute>>(source.attributes->from))
      components += attribute.components.size();
  }
  constexpr std::uint64_t kColorBytes = 8;
  return components * sizeof(float) + kColorBytes;
}

// Returns the memory of vertex attributes: other volumes, world positions of vertices, values and a color. `vertices`
// are those in memory at a time.
std::uint64_t attribute_bytes(const Source& source, std::uint64_t vertices) {
  if (!source.attributes) return 0;
  std::uint64_t bytes = vertices * (sizeof(glm::dvec3) + attribute_value_bytes(source));
  const auto* volumes = std::get_if<std::vector<VolumeAttribute>>(&source.attributes->from);
  if (volumes == nullptr) return bytes;
  for (const VolumeAttribute& attribute : *volumes) {
    for (const field::ScalarField& field : attribute.components) {
      const ConversionSize size = size_of_samples(field);
      bytes += size.sample_bytes + size.lookup_bytes;
    }
  }
  return bytes;
}

// Returns the memory that simplifying takes besides a mesh of two triangles for each vertex. Fits the measured peaks of
// gyroids of 79,000 to 496,000 vertices; the reservations cover the worst case, about twice as much. The limit leaves
// `left` bytes for it.
std::uint64_t simplify_bytes(const ConversionJob& job, std::uint64_t vertices, std::uint64_t left) {
  constexpr std::uint64_t kMiB = 1 << 20;
  if (!job.edits.simplify) return 0;
  const std::uint64_t triangles = 2 * vertices;
  const auto& target = job.edits.simplify->triangles;
  const std::uint64_t wanted = target ? wanted_triangles(*target, triangles) : 0;
  const std::uint64_t at_once = edit::simplified_at_once(vertices, triangles, wanted, left);
  // The last patch of a target holds the rest of the mesh; above 70 % the first is the last.
  if (target) return 24 * kMiB + std::clamp(220 * at_once + 300 * wanted, 250 * at_once, 430 * at_once);
  return 13 * kMiB + at_once * 250;
}

// Returns the memory that the inner wall of a surface takes; 0 if the job hollows none.
std::uint64_t hollow_bytes(const ConversionJob& job, const Source& source, std::uint64_t triangles, double area) {
  if (!job.edits.hollow) return 0;
  const double thickness = thickness_or_zero(*job.edits.hollow, source);
  if (thickness <= 0) return 0;
  return extract::estimated_wall_bytes(triangles, area, wall_cell(thickness, source));
}

// Returns the most bytes of meshes that wait for an output while more come.
std::uint64_t most_held_bytes(const ConversionJob& job, const Source& source, const OutputFileJob& output, MeshUse use,
                              const Context& context) {
  if (use == MeshUse::whole || job.writes<MeshFileOptions>() == nullptr)
    return std::numeric_limits<std::uint64_t>::max();
  return mesh_io::most_held_bytes(output.path, write_options(job, source, false), context);
}

Result<std::uint64_t> memory_of_labels(const ConversionJob& job, const Source& source,
                                       const extract::LabelChoice& choice, MeshUse use, const Context& context) {
  const extract::LabelMapSize size =
      TRY(extract::estimate_label_map(source.field, extract_options_of(job, source, 0), choice, context));
  // A fit to the measured peaks of maps of 8 to 4,096 labels with 0.3 to 8 million faces.
  const std::uint64_t simplifying = 400 * size.faces + 85 * size.sides;
  std::uint64_t most_held = 0;
  for (const OutputFileJob& output : job.outputs) {
    if (LabelFileNames(output.path).in_use()) continue;
    most_held = std::max(most_held, most_held_bytes(job, source, output, use, context));
  }
  const std::uint64_t making = job.edits.simplify
                                   ? simplifying
                                   : label_making_bytes(size, most_held, packing_bytes(job, size.largest_sides).work);
  return estimated_label_bytes(source.field, size, making) + attribute_bytes(source, size.largest_sides);
}

// Returns the memory of the samples, and of the tree or the dense samples that the writer makes from them.
std::uint64_t field_file_bytes(const field::ScalarField& field, volume_io::VolumeFileFormat format) {
  const ConversionSize size = size_of_samples(field);
  if (format == volume_io::VolumeFileFormat::vdb) return size.sample_bytes + size.samples * 2 * sizeof(float);
  if (std::holds_alternative<field::DenseSamples>(field.samples)) return size.sample_bytes;
  return size.sample_bytes + size.lookup_bytes + field::resampled_box(field).count() * field::sample_size(field.type());
}

// Returns the estimated memory of the surfaces of one grid.
Result<std::uint64_t> memory_of_grid(const ConversionJob& job, const std::optional<std::string>& grid, MeshUse use,
                                     const MemoryBudget& memory) {
  const Context context(memory.part());
  if (job.writes<ParticleFileOptions>() != nullptr) {
    return kProgramBytes + TRY(particle_file_memory(job, context));
  }
  Events unheard;
  const auto source = TRY(open_source(with_grid(job.source, grid), use_of(job), context, unheard));
  if (source.of_meshes) {
    std::uint64_t vertices = 0;
    std::uint64_t most_hollow = 0;
    for (const mesh::Mesh& mesh : source.meshes) {
      vertices += mesh.positions.size();
      if (!job.edits.hollow) continue;
      most_hollow =
          std::max(most_hollow, hollow_bytes(job, source, mesh.triangles.size(), mesh::measure_size(mesh).area));
    }
    return kProgramBytes + kConversionBytes + context.memory().peak() +
           std::max({simplify_bytes(job, vertices, context.memory().left()), packing_bytes(job, vertices).work,
                     most_hollow});
  }
  // Making a field takes more memory than keeping it: from particles, by a blur, or in another resolution.
  std::uint64_t most = kProgramBytes + context.memory().peak();
  if (const auto* file = job.writes<FieldFileOptions>()) {
    most = std::max(most, kProgramBytes + field_file_bytes(source.field, file->format));
  }
  if (const auto labels = chosen_labels(source.isos, job.surface.background))
    return std::max(most, TRY(memory_of_labels(job, source, *labels, use, context)));
  std::vector<WaitingMeshes> waiting;
  for (const OutputFileJob& output : job.outputs) {
    waiting.emplace_back(most_held_bytes(job, source, output, use, context));
  }
  std::uint64_t without_meshes = 0;
  for (const ResolvedIso& iso : source.isos) {
    const ConversionSize size = size_of(source.field, extract_options_of(job, source, iso.id.iso()));
    const bool selects = job.edits.pieces.drops();
    const std::uint64_t sampling = source.attributes ? size.vertices * sampling_bytes(*source.attributes) : 0;
    const std::uint64_t selecting =
        edit::whole_selection_bytes(size.vertices, estimated_triangles(size), job.normals == Normals::smooth);
    const bool measures = use == MeshUse::figures || !job.edits.require.empty();
    const mesh::MeshShape shape{.vertices = size.vertices,
                                .triangles = estimated_triangles(size),
                                .has_normals = job.normals == Normals::smooth};
    const bool by_parts = use != MeshUse::whole &&
                          goes_by_parts(job, source, iso.id.iso(), size.has_nan.value_or(true)) &&
                          !(size.has_nan.value_or(false) && shape.has_normals) &&
                          (!selects || !holds_whole_selection(shape, sampling, measures, context.memory().left()));
    const bool has_figures = measures || selects;
    std::uint64_t bytes =
        by_parts ? estimated_bytes_by_parts(size, job.meshes(), job.normals, has_figures) : estimated_bytes(size);
    bytes += attribute_bytes(source, by_parts ? vertices_sampled_at_once(size.vertices) : size.vertices);
    std::uint64_t after = simplify_bytes(job, size.vertices, memory.limit() - std::min(memory.limit(), bytes));
    // About a vertex for each cell that the surface crosses.
    const double cell_area = std::pow(std::abs(source.output_from_index.determinant()), 2.0 / 3);
    after = std::max(
        after, hollow_bytes(job, source, estimated_triangles(size), static_cast<double>(size.vertices) * cell_area));
    if (selects && !by_parts) after = std::max(after, selecting / 5 * 3);
    if (job.error) after = std::max(after, estimated_error_bytes(source, iso.id.iso()));
    most = std::max(most, bytes + after);
    without_meshes = std::max(without_meshes, bytes_without_mesh(size));
    const std::uint64_t own_bytes = mesh_bytes(size.vertices, true) + size.vertices * attribute_value_bytes(source);
    const PackingBytes packing = packing_bytes(job, size.vertices);
    for (std::size_t file = 0; file < waiting.size(); ++file) {
      if (std::ranges::find(job.outputs[file].isos, iso.asked) == job.outputs[file].isos.end()) continue;
      most = std::max(most, waiting[file].bytes() + bytes + after);
      if (waiting[file].packs_at_once()) most = std::max(most, bytes + packing.work);
      waiting[file].add(own_bytes, packing);
    }
  }
  for (const WaitingMeshes& meshes : waiting) most = std::max(most, without_meshes + meshes.packing_peak());
  return most;
}

// Returns how many different x the blocks have: the sparse extractor makes a part for each.
std::uint64_t count_layers(const field::SparseSamples& samples) {
  std::vector<int> layers;
  for (const field::SparseBlock& block : samples.blocks) {
    if (layers.empty() || layers.back() != block.origin.x) layers.push_back(block.origin.x);
  }
  std::ranges::sort(layers);
  layers.erase(std::unique(layers.begin(), layers.end()), layers.end());
  return layers.size();
}

// Returns the memory of `parts` parts of a mesh if the whole mesh takes `bytes`.
std::uint64_t bytes_of_parts(const ConversionSize& size, std::uint64_t parts, std::uint64_t bytes) {
  return bytes / size.slabs * std::min(parts, size.slabs) * 5 / 4;
}

// Returns the memory of the parts of a mesh that are in memory at a time, and of the records that the writer makes.
std::uint64_t parts_bytes(const ConversionSize& size, const MeshFileOptions& file, Normals normals) {
  const bool has_normals = normals == Normals::smooth;
  const auto threads = static_cast<std::uint64_t>(usable_threads());
  const std::uint64_t record_bytes = 2 * threads << 20U;  // files::write_records()
  const auto of_parts = [&](std::uint64_t parts, std::uint64_t bytes) { return bytes_of_parts(size, parts, bytes); };
  // Face normals need the vertices of a second part, too.
  if (file.format == mesh_io::MeshFormat::stl || normals == Normals::flat)
    return of_parts(2, mesh_bytes(size.vertices, false)) + record_bytes;
  if (file.format == mesh_io::MeshFormat::obj || file.ascii) {
    // A pass has either the vertices or the triangles.
    const std::uint64_t vertex_bytes =
        mesh_bytes(size.vertices, has_normals) - estimated_triangles(size) * sizeof(glm::uvec3);
    return of_parts(1, std::max(vertex_bytes, estimated_triangles(size) * sizeof(glm::uvec3))) + record_bytes;
  }
  return of_parts(threads, mesh_bytes(size.vertices, has_normals));
}

// Returns the memory of a part of a mesh while mesh::PartwiseMeasures measures it.
std::uint64_t measuring_bytes(std::uint64_t vertices) {
  // The part that waits, and the corners at its vertices.
  constexpr std::uint64_t kVertexBytes = 2 * sizeof(glm::vec3) + 5 * sizeof(std::uint32_t) + sizeof(std::uint64_t);
  constexpr std::uint64_t kTriangleBytes = 2 * sizeof(glm::uvec3) + 3 * sizeof(std::uint64_t);
  return mesh_bytes(vertices, false) + vertices * (kVertexBytes + 2 * kTriangleBytes);
}

std::uint64_t count_rows(const field::IndexBox& region) {
  const glm::u64vec3 dims(region.dims());
  return dims.y * dims.z;
}

// Returns the sizes of the samples for a surface in a region of them, which matters for dense samples.
// A thread holds `slices_at_work` slices of a large mapped file.
ConversionSize size_in(const field::ScalarField& field, const field::IndexBox& region, int slices_at_work) {
  ConversionSize size;
  const auto* dense = std::get_if<field::DenseSamples>(&field.samples);
  if (dense == nullptr) {
    const auto& sparse = std::get<field::SparseSamples>(field.samples);
    constexpr std::uint64_t kBlockSamples =
        std::uint64_t{field::SparseBlock::kSize} * field::SparseBlock::kSize * field::SparseBlock::kSize;
    size.samples = sparse.blocks.size() * kBlockSamples;
    size.sample_bytes = size.resident_bytes = size.samples * field::sample_size(field.type());
    size.lookup_bytes = field::SparseLookup::bytes(sparse);
    size.mark_bytes = size.samples / 4;  // measured
    size.slabs = count_layers(sparse);
    return size;
  }
  constexpr std::uint64_t kRowBytes = 20;  // of the tables of Method::mc
  const glm::ivec3 dims(region.dims());
  const auto slices = static_cast<std::uint64_t>(dims.z);
  size.samples = dense->count();
  size.sample_bytes = size.resident_bytes = size.samples * field::sample_size(field.type());
  size.mark_bytes = extract::DenseMasks::bytes(dims) + count_rows(region) * kRowBytes;
  size.slabs = (slices + extract::kBrickRows - 1) / extract::kBrickRows;
  if (dense->releases_pages()) {
    const std::uint64_t slice_bytes = size.sample_bytes / static_cast<std::uint64_t>(dense->dims.z);
    const auto at_work = static_cast<std::uint64_t>(usable_threads()) * static_cast<std::uint64_t>(slices_at_work);
    size.resident_bytes = slice_bytes / static_cast<std::uint64_t>(dense->dims.y) * static_cast<std::uint64_t>(dims.y) *
                          std::min(at_work, slices);
  }
  return size;
}

}  // namespace

ConversionSize size_of_samples(const field::ScalarField& field) {
  return size_in(field, field.extents(), extract::kSlabSlices);
}

ConversionSize size_of(const field::ScalarField& field, const extract::ExtractOptions& options) {
  // Method::mt has a vertex on all edges of tetrahedra: a plane of mean slope crosses three times as many.
  constexpr std::uint64_t kMtVertices = 3;
  constexpr std::uint64_t kMtRowBytes = 16;  // of the tables, more than those of Method::mc
  field::IndexBox region = field.extents();
  if (const auto clipped = extract::clip_region(field, region, options)) region = *clipped;
  const auto* dense = std::get_if<field::DenseSamples>(&field.samples);
  const bool is_of_cells = extract::method_info(options.method).traits.vertices_on_edges;
  const bool leaves_slices = dense != nullptr && is_of_cells && !extract::slabs_may_stay(*dense);
  ConversionSize size = size_in(field, region, leaves_slices ? extract::kSlicesAtWork : extract::kSlabSlices);
  const field::SurfaceEstimate surface = field::estimate_surface(field, options.iso, region);
  size.vertices = surface.vertices;
  size.places = surface.places;
  if (dense != nullptr) size.has_nan = surface.has_nan;
  if (options.method == extract::Method::mt) {
    size.vertices *= kMtVertices;
    if (dense != nullptr) size.mark_bytes += count_rows(region) * kMtRowBytes;
  }
  if (options.cap && !extract::method_info(options.method).traits.always_closed) size.cap_vertices = surface.boundary;
  size.vertices += size.cap_vertices;
  return size;
}

std::uint64_t estimated_triangles(const ConversionSize& size) { return 2 * size.vertices; }

std::uint64_t estimated_bytes(const ConversionSize& size) {
  return bytes_without_mesh(size) + mesh_bytes(size.vertices, true);
}

std::uint64_t estimated_bytes_by_parts(const ConversionSize& size, const MeshFileOptions& file, Normals normals,
                                       bool has_figures) {
  if (size.slabs == 0) return estimated_bytes(size);
  ConversionSize surface = size;  // the cap is a part by itself
  surface.vertices -= size.cap_vertices;
  std::uint64_t parts = std::max(parts_bytes(surface, file, normals), mesh_bytes(size.cap_vertices, false));
  if (has_figures) {
    parts = std::max(
        {parts, bytes_of_parts(size, 1, measuring_bytes(surface.vertices)), measuring_bytes(size.cap_vertices)});
  }
  return bytes_without_mesh(size) + parts;
}

std::uint64_t label_making_bytes(const extract::LabelMapSize& size, std::uint64_t most_held, std::uint64_t edit_bytes) {
  const std::uint64_t waiting = std::min(size.mesh_bytes - size.largest_bytes, most_held);
  // Of the two groups in memory, one may wait already. The allocator keeps freed blocks of less than 1 MiB; surfaces
  // that wait take them.
  const std::uint64_t made = std::max(size.largest_bytes, size.group_bytes / 2);
  const std::uint64_t making = std::min(size.mesh_bytes, std::max(size.group_bytes / 2 * 3, waiting + made));
  return std::max(making + size.listing_bytes, waiting + size.largest_bytes + edit_bytes);
}

std::uint64_t estimated_label_bytes(const field::ScalarField& field, const extract::LabelMapSize& size,
                                    std::uint64_t making_bytes) {
  constexpr std::uint64_t kLabelBytes = 6 << 10U;  // of the names, reports and records of a mesh, measured
  const ConversionSize samples = size_of_samples(field);
  const auto* dense = std::get_if<field::DenseSamples>(&field.samples);
  const bool is_read_once = dense != nullptr && dense->file_backed;
  const std::uint64_t kept_samples = is_read_once ? 0 : samples.sample_bytes + samples.lookup_bytes;
  const std::uint64_t most =
      std::max({samples.resident_bytes + samples.lookup_bytes + size.voxel_bytes, kept_samples + size.finding_bytes,
                kept_samples + size.kept_bytes + making_bytes + kLabelBytes * size.labels});
  return kProgramBytes + kConversionBytes + most;
}

Result<std::uint64_t> estimated_memory(const ConversionJob& job, MeshUse use, const MemoryBudget& memory) {
  std::uint64_t most = 0;
  for (const std::optional<std::string>& grid : grids_of(job.source)) {
    const auto bytes = memory_of_grid(job, grid, use, memory);
    if (!bytes) return bytes;
    most = std::max(most, *bytes);
  }
  return most;
}

}  // namespace isoextract::convert
