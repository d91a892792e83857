#include "extract/mesh_assembly.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace isoextract::extract {

Result<void> check_request(const field::ScalarField& field, const ExtractOptions& options) {
  if (!std::isfinite(options.iso)) {
    return fail(ErrorCode::usage, fmt::format("the iso value must be a finite number, found {}", options.iso));
  }
  if (!options.output_from_index.is_invertible()) {
    return fail(ErrorCode::input,
                fmt::format("{}: its transform from indices to coordinates is singular or not finite", field.source),
                {Remedy::give, Setting::spacing_and_origin});
  }
  return {};
}

Result<field::IndexBox> clip_region(const field::ScalarField& field, const field::IndexBox& box,
                                    const ExtractOptions& options) {
  field::IndexBox region = box;
  if (options.region) {
    region.min = glm::max(region.min, options.region->min);
    region.max = glm::min(region.max, options.region->max);
  }
  if (glm::all(glm::greaterThan(region.max, region.min))) return region;
  if (!options.region) {
    const auto dims = box.dims();
    return fail(ErrorCode::input,
                fmt::format("{}: a surface needs at least 2 samples along each axis, found {} x {} x {}", field.source,
                            dims.x, dims.y, dims.z),
                dims.z == 1 ? Hint{"give the pattern of numbered pictures, such as 'slice_####.tif' in quotes, to read "
                                   "them as the slices of one volume",
                                   {Remedy::use, Setting::height_field}}
                            : Hint());
  }
  return fail(
      ErrorCode::input,
      fmt::format(
          "{}: the region contains no cell of the field; the samples have the indices ({}, {}, {}) to ({}, {}, {})",
          field.source, box.min.x, box.min.y, box.min.z, box.max.x, box.max.y, box.max.z),
      {{Remedy::check, Setting::region, "it has to overlap the box of the data, which 'isoextract info' prints"},
       {Remedy::leave_out, Setting::region}});
}

Result<void> check_placement(const field::ScalarField& field, const OutputPlacement& placement) {
  if (placement.fits_float32()) return {};
  if (placement.exceeds_float32_precision()) {
    return fail(ErrorCode::input,
                fmt::format("{}: the data extend over more than about 2^20 samples along an axis: float32 positions "
                            "cannot distinguish neighboring vertices",
                            field.source),
                {Remedy::use, Setting::parts});
  }
  return fail(
      ErrorCode::input,
      fmt::format("{}: its coordinates or its voxel sizes are outside the range of float32 positions", field.source),
      {Remedy::change, Setting::scale});
}

namespace {

std::uint64_t array_bytes(const MeshSizes& sizes, const ExtractOptions& options) {
  const std::uint64_t vertex_bytes =
      sizeof(glm::vec3) * (options.smooth_normals ? 2 : 1) + (options.edge_keys ? sizeof(mesh::EdgeKey) : 0);
  return sizes.vertices * vertex_bytes + sizes.triangles * sizeof(glm::uvec3);
}

}  // namespace

Result<void> check_vertex_count(const field::ScalarField& field, const MeshSizes& sizes) {
  if (sizes.vertices <= std::numeric_limits<std::uint32_t>::max()) return {};
  return fail(ErrorCode::input,
              fmt::format("{}: the surface has {} vertices; a mesh can have at most {}", field.source, sizes.vertices,
                          std::numeric_limits<std::uint32_t>::max()),
              {Remedy::use, Setting::parts});
}

Result<Reservation> reserve_mesh(const field::ScalarField& field, const MeshSizes& sizes, const ExtractOptions& options,
                                 const Context& context) {
  return context.reserve(array_bytes(sizes, options),
                         fmt::format("{}: the {} triangles of its surface", field.source, sizes.triangles));
}

MeshSizes with_cap(const MeshSizes& surface, const BoundaryCap& cap) {
  return {surface.vertices + cap.sample_places.all, surface.triangles + cap.triangle_places.all};
}

Result<Reservation> reserve_cap_numbers(const field::ScalarField& field, const field::IndexBox& box,
                                        const Context& context) {
  const glm::u64vec3 dims(box.dims());
  const std::uint64_t squares = 2 * (dims.x * dims.y + dims.y * dims.z + dims.z * dims.x);
  return context.reserve(squares * sizeof(std::uint32_t),
                         fmt::format("{}: the table of the {} samples on the data boundary", field.source, squares));
}

Result<Reservation> reserve_cap(const field::ScalarField& field, const BoundaryCap& cap, const Context& context) {
  return context.reserve(cap.samples.capacity() * sizeof(glm::ivec3) + cap.triangles.capacity() * sizeof(glm::uvec3),
                         fmt::format("{}: the {} triangles of its cap", field.source, cap.triangles.size()));
}

tl::unexpected<Error> nan_error(const field::ScalarField& field, std::uint64_t count, const glm::ivec3& first) {
  const glm::dvec3 voxel = field.index_to_file(first);
  return fail(ErrorCode::input,
              fmt::format("{}: {} of the samples {} not a number (NaN), the first at index ({:.10g}, {:.10g}, {:.10g})",
                          field.source, count, count == 1 ? "is" : "are", voxel.x, voxel.y, voxel.z),
              {{Remedy::set, Setting::nan_policy, "outside to treat them as outside"},
               {Remedy::set, Setting::nan_policy, "hole to leave the surface open around them"}});
}

void allocate_mesh(mesh::Mesh& mesh, const MeshSizes& surface, const BoundaryCap& cap, const ExtractOptions& options) {
  mesh.positions = Buffer<glm::vec3>(surface.vertices + cap.samples.size());
  if (options.smooth_normals) mesh.normals = Buffer<glm::vec3>(mesh.positions.size());
  if (options.edge_keys) mesh.edges = Buffer<mesh::EdgeKey>(mesh.positions.size());
  mesh.triangles = Buffer<glm::uvec3>(surface.triangles + cap.triangles.size());
}

Result<void> fill_normals(mesh::Mesh& mesh, const MeshSizes& surface, const field::ScalarField& field,
                          const Context& context) {
  struct Unknown {
    std::uint32_t vertex;
    glm::dvec3 sum{0.0};  // sum of the triangle normals, each of length twice the area
    double lengths = 0;
  };
  const std::span<glm::vec3> normals(mesh.normals.data(), surface.vertices);
  const auto count = static_cast<std::uint64_t>(std::ranges::count_if(normals, OutputPlacement::is_placeholder_normal));
  if (count == 0) return {};
  auto memory = TRY(context.reserve(
      count * sizeof(Unknown), fmt::format("{}: the normals of {} vertices next to NaN samples", field.source, count)));
  std::vector<Unknown> unknown;
  unknown.reserve(count);
  for (std::size_t v = 0; v < normals.size(); ++v) {
    if (OutputPlacement::is_placeholder_normal(normals[v])) unknown.push_back({static_cast<std::uint32_t>(v)});
  }
  for (const glm::uvec3& corners : std::span(mesh.triangles.data(), surface.triangles)) {
    for (int corner = 0; corner < 3; ++corner) {
      if (!OutputPlacement::is_placeholder_normal(normals[corners[corner]])) continue;
      const glm::dvec3 a(mesh.positions[corners.x]);
      const glm::dvec3 area = glm::cross(glm::dvec3(mesh.positions[corners.y]) - a,  //
                                         glm::dvec3(mesh.positions[corners.z]) - a);
      Unknown& one = *std::ranges::lower_bound(unknown, corners[corner], {}, &Unknown::vertex);
      one.sum += area;
      one.lengths += glm::length(area);
    }
  }
  constexpr double kCancels = 1e-6;  // a smaller sum (relative) is rounding error
  for (const Unknown& one : unknown) {
    glm::vec3& normal = normals[one.vertex];
    const double length = glm::length(one.sum);
    normal = length > kCancels * one.lengths ? glm::vec3(one.sum / length) : normal / 2.0F;
  }
  return {};
}

void append_cap(mesh::Mesh& mesh, const MeshSizes& surface, const BoundaryCap& cap, const field::IndexBox& box,
                const OutputPlacement& placement) {
  for (std::size_t v = 0; v < cap.samples.size(); ++v) {
    const std::size_t number = surface.vertices + v;
    const glm::ivec3& sample = cap.samples[v];
    mesh.positions[number] = placement.position(glm::dvec3(sample));
    if (!mesh.edges.empty()) mesh.edges[number] = {sample, 0};
    if (!mesh.normals.empty()) {
      mesh.normals[number] = placement.plane_normal(boundary_normal(box, sample));
    }
  }
  for (std::size_t t = 0; t < cap.triangles.size(); ++t) {
    const glm::uvec3 corners = cap.triangles[t];
    mesh.triangles[surface.triangles + t] =
        placement.mirrored() ? glm::uvec3(corners.x, corners.z, corners.y) : corners;
  }
}

ExtractOptions options_in(const mesh::PartPass& pass, ExtractOptions options) {
  options.smooth_normals = options.smooth_normals && pass.normals;
  return options;
}

MeshSizes sizes_in(const mesh::PartPass& pass, const MeshSizes& sizes) {
  return {pass.positions || pass.normals ? sizes.vertices : 0, pass.triangles ? sizes.triangles : 0};
}

Result<void> deliver_part(mesh::MeshSink& sink, const mesh::PartPass& pass, const mesh::Mesh& part,
                          const MeshSizes& first, const MeshSizes& sizes) {
  return sink.take({first.vertices, part.positions.span().first(pass.positions ? sizes.vertices : 0),
                    part.normals.span().first(part.normals.empty() ? 0 : sizes.vertices), first.triangles,
                    part.triangles.span().first(sizes.triangles)});
}

Result<bool> offer_mesh(mesh::MeshSink& sink, mesh::MeshShape shape, const MeshSizes& surface, const BoundaryCap& cap,
                        const std::optional<RankSlices>& share, const Context& context) {
  std::vector<std::uint32_t>& rim = shape.far_vertices;
  if (share) {
    const auto memory = TRY(context.reserve(share->shared_vertices * sizeof(std::uint32_t), "the vertices of a slice"));
    rim.resize(share->shared_vertices);
    std::iota(rim.begin(), rim.end(), share->first_shared_vertex);
    return sink.begin(shape);
  }
  const auto for_each_reference = [&](const auto& visit) {
    for (const glm::uvec3& triangle : cap.triangles) {
      for (int corner = 0; corner < 3; ++corner) {
        if (triangle[corner] < surface.vertices) visit(triangle[corner]);
      }
    }
  };
  std::uint64_t count = 0;
  for_each_reference([&](std::uint32_t /*vertex*/) { ++count; });
  const auto memory = TRY(context.reserve(count * sizeof(std::uint32_t), "the vertices around a cap"));
  rim.reserve(count);
  for_each_reference([&](std::uint32_t vertex) { rim.push_back(vertex); });
  std::ranges::sort(rim);
  rim.erase(std::unique(rim.begin(), rim.end()), rim.end());
  return sink.begin(shape);
}

Result<void> deliver_cap(mesh::MeshSink& sink, const mesh::PartPass& pass, const MeshSizes& surface,
                         const BoundaryCap& cap, const field::IndexBox& box, const OutputPlacement& placement,
                         const ExtractOptions& options, const Context& context) {
  const ExtractOptions wanted = options_in(pass, options);
  const auto memory =
      TRY(context.reserve(array_bytes({cap.samples.size(), cap.triangles.size()}, wanted), "the triangles of a cap"));
  mesh::Mesh whole;
  allocate_mesh(whole, {}, cap, wanted);
  append_cap(whole, {}, cap, box, placement);
  const std::vector<CapRun>& vertices = cap.sample_places.runs;
  const std::vector<CapRun>& triangles = cap.triangle_places.runs;
  MeshSizes done;
  for (std::size_t run = 0; run < std::max(vertices.size(), triangles.size()); ++run) {
    const CapRun of_vertices = run < vertices.size() ? vertices[run] : CapRun();
    const CapRun of_triangles = run < triangles.size() ? triangles[run] : CapRun();
    const MeshSizes sizes = sizes_in(pass, {of_vertices.count, of_triangles.count});
    mesh::MeshPart part{surface.vertices + of_vertices.first, {}, {}, surface.triangles + of_triangles.first, {}};
    if (pass.positions) part.positions = whole.positions.span().subspan(done.vertices, sizes.vertices);
    if (!whole.normals.empty()) part.normals = whole.normals.span().subspan(done.vertices, sizes.vertices);
    part.triangles = whole.triangles.span().subspan(done.triangles, sizes.triangles);
    if (sizes.vertices > 0 || sizes.triangles > 0) TRY(sink.take(part));
    done.vertices += of_vertices.count;
    done.triangles += of_triangles.count;
  }
  return {};
}

}  // namespace isoextract::extract
