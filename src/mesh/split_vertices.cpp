#include "mesh/split_vertices.hpp"

#include <algorithm>
#include <limits>
#include <new>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "base/allocation_error.hpp"
#include "base/parallel.hpp"
#include "mesh/adjacency.hpp"

namespace isoextract::mesh {
namespace {

// `what` says what the memory is for.
Result<void> split_fans(Mesh& mesh, const std::string& source, const std::string& what, const Context& context) {
  const auto vertices = static_cast<std::uint32_t>(mesh.positions.size());
  const auto old_triangles = std::as_const(mesh.triangles).span();
  const Adjacency adjacency(old_triangles, vertices);
  Buffer<glm::uvec3> triangles(old_triangles.size());  // holds the fan of each corner, then its new vertex
  Buffer<std::uint32_t> first(vertices);               // holds the number of fans, then the first new vertex
  constexpr std::uint32_t kVerticesAtOnce = 1 << 10;
  const auto at_corner = [&](Corner corner) -> std::uint32_t& {
    return triangles[triangle_of(corner)][static_cast<int>(corner % 3)];
  };
  for_each_range(vertices, kVerticesAtOnce, [&](std::size_t begin, std::size_t end) {
    VertexStar star;
    for (auto v = static_cast<std::uint32_t>(begin); v != end; ++v) {
      const auto corners = adjacency.corners(v);
      star.look_at(corners, old_triangles);
      first[v] = star.fans();
      for (std::size_t i = 0; i < corners.size(); ++i) at_corner(corners[i]) = star.fan_of()[i];
    }
  });

  const std::uint64_t all = std::accumulate(first.begin(), first.end(), std::uint64_t{0});
  if (all > std::numeric_limits<std::uint32_t>::max()) {
    return fail(ErrorCode::input, fmt::format("{}: the surface has more vertices than 32-bit indices allow", source),
                {Remedy::use, Setting::parts});
  }
  const auto memory = TRY(context.reserve(all * (vertex_bytes(mesh) + sizeof(std::uint32_t)), what));
  Buffer<std::uint32_t> source_of(all);  // the old vertex of each new one
  std::uint32_t number = 0;
  for (std::uint32_t v = 0; v < vertices; ++v) {
    const std::uint32_t fans = std::exchange(first[v], number);
    std::fill_n(source_of.begin() + number, fans, v);
    number += fans;
  }
  for_each_range(vertices, kVerticesAtOnce, [&](std::size_t begin, std::size_t end) {
    for (auto v = static_cast<std::uint32_t>(begin); v != end; ++v) {
      for (const Corner corner : adjacency.corners(v)) at_corner(corner) += first[v];
    }
  });
  gather_vertices(mesh, source_of.span());
  mesh.triangles = std::move(triangles);
  return {};
}

}  // namespace

Result<void> split_nonmanifold_vertices(Mesh& mesh, const std::string& source, const Context& context) {
  const std::uint64_t vertices = mesh.positions.size();
  const std::uint64_t bytes = Adjacency::bytes(mesh.triangles.size(), vertices) + mesh.triangles.size_bytes() +
                              vertices * sizeof(std::uint32_t);
  const std::string what = fmt::format("{}: the holes of its surface", source);
  const auto memory = TRY(context.reserve(bytes, what));
  try {
    return split_fans(mesh, source, what, context);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(
        allocation_error(fmt::format("{} need more memory than is available", what), {Remedy::use, Setting::parts}));
  }
}

}  // namespace isoextract::mesh
