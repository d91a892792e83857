#include "edit/bodies.hpp"

#include <algorithm>
#include <cstring>
#include <memory>
#include <numeric>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include "edit/detail/body_choice.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/component_facts.hpp"
#include "mesh/shells.hpp"

namespace isoextract::edit {
namespace {

using mesh::ComponentFacts;
using mesh::Components;

// The component of a vertex when mark_bodies() ran, and the body of that component.
struct BodyMark {
  std::uint32_t component;
  std::uint32_t body;
};
constexpr std::string_view kBodyMarks = "bodies of components";

// Returns null if there are none.
const mesh::Attribute* find_marks(const mesh::Mesh& mesh) {
  const auto found = std::ranges::find(mesh.attributes, kBodyMarks, &mesh::Attribute::name);
  return found == mesh.attributes.end() ? nullptr : std::to_address(found);
}

Result<Nesting> find_nesting(const mesh::Mesh& mesh, const Components& components,
                             const std::vector<ComponentFacts>& facts, const Context& context) {
  if (!has_cavities(facts)) return Nesting::without_cavities(facts.size());
  return nesting_of(facts, TRY(find_enclosing_shells(mesh, components, shell_query(facts), context)));
}

// The measured components of a mesh and their nesting.
struct Shells {
  Components components;
  std::vector<ComponentFacts> facts;
  Nesting nesting;
  Reservation memory;

  // Takes the nesting from `marks`; without marks, from the positions.
  static Result<Shells> find(const mesh::Mesh& mesh, const glm::dmat3& to_metric, const Context& context,
                             const mesh::Attribute* marks = nullptr) {
    const std::string what = mesh.name + ": the components of its surface";
    auto memory = TRY(context.reserve(Components::bytes(mesh.positions.size()), what));
    Components components(mesh.triangles.span(), mesh.positions.size());
    auto list = TRY(context.reserve(components.count() * kComponentBytes, what));
    memory.take(std::move(list));
    auto facts = TRY(measure_components(mesh, components, to_metric, context));
    Nesting nesting = marks != nullptr ? marked_nesting(*marks, components, mesh.positions.size())
                                       : TRY(find_nesting(mesh, components, facts, context));
    return Shells{std::move(components), std::move(facts), std::move(nesting), std::move(memory)};
  }

  // Calls find() with `sites` as positions, then restores the mesh's positions.
  static Result<Shells> find_at(OriginalPositions sites, mesh::Mesh& mesh, const glm::dmat3& to_metric,
                                const Context& context) {
    if (sites.empty()) return find(mesh, to_metric, context);
    std::swap(mesh.positions, sites);
    auto shells = find(mesh, to_metric, context);
    std::swap(mesh.positions, sites);
    return shells;
  }

  // Reads the nesting from the marks. If the body of a cavity no longer exists, the cavity becomes its own body.
  static Nesting marked_nesting(const mesh::Attribute& marks, const Components& components, std::size_t vertices) {
    std::vector<BodyMark> mark_of(components.count());
    std::unordered_map<std::uint32_t, std::uint32_t> number_of;
    for (std::size_t v = 0; v < vertices; ++v) {
      const std::uint32_t component = components.of_vertex(v);
      if (component == Components::kNone) continue;
      std::memcpy(&mark_of[component], marks.at(v).data(), sizeof(BodyMark));
      number_of[mark_of[component].component] = component;
    }
    Nesting nesting;
    nesting.within.assign(mark_of.size(), Nesting::kNone);
    for (std::uint32_t i = 0; i < mark_of.size(); ++i) {
      const auto body = number_of.find(mark_of[i].body);
      nesting.body.push_back(body == number_of.end() ? i : body->second);
    }
    return nesting;
  }

  [[nodiscard]] std::size_t count() const { return facts.size(); }
};

// Removes the components that do not stay.
Result<void> remove_components(mesh::Mesh& mesh, const Components& components, const std::vector<bool>& stays,
                               std::uint64_t triangles, const Context& context) {
  const auto remains = [&](std::size_t vertex) {
    const std::uint32_t component = components.of_vertex(vertex);
    return component != Components::kNone && stays[component];
  };
  std::uint64_t vertices = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) vertices += remains(v) ? 1 : 0;
  const std::uint64_t left = vertices * vertex_bytes(mesh) + triangles * sizeof(glm::uvec3);
  const auto memory = TRY(context.reserve(left + (vertices + mesh.positions.size()) * sizeof(std::uint32_t),
                                          mesh.name + ": the remaining part of its surface"));
  Buffer<std::uint32_t> old_of_new(vertices);
  Buffer<std::uint32_t> new_of_old(mesh.positions.size());
  std::uint32_t next = 0;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    if (!remains(v)) continue;
    old_of_new[next] = v;
    new_of_old[v] = next++;
  }
  Buffer<glm::uvec3> kept(triangles);
  glm::uvec3* to = kept.begin();
  for (const glm::uvec3& t : mesh.triangles) {
    if (!mesh::has_repeated_index(t) && remains(t.x)) *to++ = {new_of_old[t.x], new_of_old[t.y], new_of_old[t.z]};
  }
  gather_vertices(mesh, old_of_new.span());
  mesh.triangles = std::move(kept);
  mesh.memory.shrink(left);
  return {};
}

Result<SelectedBodies> keep(mesh::Mesh mesh, const BodySelection& options, const Context& context,
                            OriginalPositions sites) {
  const Stopwatch watch;
  auto shells = TRY(Shells::find_at(std::move(sites), mesh, options.to_metric, context));
  const double resolution = options.least ? mesh::float32_resolution(mesh.positions.span()) : 0;
  auto [stays, facts] = choose_bodies(shells.facts, shells.nesting, options, resolution);
  if (facts.after.components < facts.before.components) {
    TRY(remove_components(mesh, shells.components, stays, facts.after.triangles, context));
  }
  facts.time = watch.elapsed();
  return SelectedBodies{std::move(mesh), facts};
}

// Vertices and triangles sorted by body; body p has the range first[p] to first[p + 1].
struct PieceLists {
  Buffer<std::uint32_t> vertices;
  Buffer<std::uint32_t> triangles;
  std::vector<std::uint64_t> first_vertex;
  std::vector<std::uint64_t> first_triangle;
};

PieceLists list_pieces(const mesh::Mesh& mesh, const Components& components, const std::vector<std::uint32_t>& piece_of,
                       std::size_t pieces) {
  PieceLists lists{Buffer<std::uint32_t>(mesh.positions.size()), Buffer<std::uint32_t>(mesh.triangles.size()),
                   std::vector<std::uint64_t>(pieces + 1), std::vector<std::uint64_t>(pieces + 1)};
  const auto fill = [](std::size_t count, const auto& piece, std::vector<std::uint64_t>& first, auto& list) {
    for (std::size_t i = 0; i < count; ++i) {
      if (const auto p = piece(i); p != Components::kNone) ++first[p + 1];
    }
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<std::uint64_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t i = 0; i < count; ++i) {
      if (const auto p = piece(i); p != Components::kNone) list[next[p]++] = i;
    }
  };
  const auto of_vertex = [&](std::size_t v) {
    const std::uint32_t component = components.of_vertex(v);
    return component == Components::kNone ? Components::kNone : piece_of[component];
  };
  fill(mesh.positions.size(), of_vertex, lists.first_vertex, lists.vertices);
  fill(
      mesh.triangles.size(),
      [&](std::size_t t) {
        return mesh::has_repeated_index(mesh.triangles[t]) ? Components::kNone : of_vertex(mesh.triangles[t].x);
      },
      lists.first_triangle, lists.triangles);
  return lists;
}

template <class T>
Buffer<T> gathered_from(const Buffer<T>& values, std::size_t width, std::span<const std::uint32_t> old_of_new) {
  if (values.empty()) return {};
  Buffer<T> result(old_of_new.size() * width);
  for (std::size_t i = 0; i < old_of_new.size(); ++i) {
    std::copy_n(values.data() + old_of_new[i] * width, width, result.data() + i * width);
  }
  return result;
}

Result<void> mark(mesh::Mesh& mesh, const Context& context, OriginalPositions sites) {
  const auto shells = TRY(Shells::find_at(std::move(sites), mesh, glm::dmat3(1.0), context));
  auto memory =
      TRY(context.reserve(mesh.positions.size() * sizeof(BodyMark), mesh.name + ": the bodies of its vertices"));
  mesh::Attribute marks;
  marks.name = kBodyMarks;
  marks.type = mesh::ComponentType::u32;
  marks.components = 2;
  marks.values = Buffer<std::byte>(mesh.positions.size() * sizeof(BodyMark));
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const std::uint32_t component = shells.components.of_vertex(v);
    const bool used = component != Components::kNone;
    const BodyMark one{component, used ? shells.nesting.body[component] : component};
    std::memcpy(marks.values.data() + v * sizeof(BodyMark), &one, sizeof(BodyMark));
  }
  mesh.attributes.push_back(std::move(marks));
  mesh.memory.take(std::move(memory));
  return {};
}

Result<std::vector<mesh::Mesh>> split(mesh::Mesh mesh, std::uint64_t most, const Context& context) {
  auto shells = TRY(Shells::find(mesh, glm::dmat3(1.0), context, find_marks(mesh)));
  std::erase_if(mesh.attributes, [](const mesh::Attribute& attribute) { return attribute.name == kBodyMarks; });
  const auto bodies = bodies_by_area(shells.facts, shells.nesting, std::vector<bool>(shells.count(), true));
  if (bodies.size() > most) {
    return fail(ErrorCode::input,
                fmt::format("{}: the surface has {} bodies, and each needs a mesh of its own; expected at most {}",
                            mesh.name, bodies.size(), most),
                {{Remedy::use, Setting::fewer_bodies},
                 {Remedy::leave_out, Setting::split_bodies, "one mesh then holds all bodies"}});
  }
  if (bodies.size() <= 1) {
    std::vector<mesh::Mesh> one;
    if (!bodies.empty()) one.push_back(std::move(mesh));
    return one;
  }
  const std::uint64_t vertices = mesh.positions.size();
  const std::string what = mesh.name + ": the meshes of its bodies";
  const auto memory = TRY(context.reserve((2 * vertices + mesh.triangles.size()) * sizeof(std::uint32_t), what));
  std::vector<std::uint32_t> piece_of(shells.count());
  for (std::uint32_t p = 0; p < bodies.size(); ++p) piece_of[bodies[p]] = p;
  for (std::size_t i = 0; i < shells.count(); ++i) piece_of[i] = piece_of[shells.nesting.body[i]];
  const PieceLists lists = list_pieces(mesh, shells.components, piece_of, bodies.size());
  Buffer<std::uint32_t> new_of_old(vertices);
  std::vector<mesh::Mesh> pieces(bodies.size());
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    const auto part = [p](const Buffer<std::uint32_t>& list, const std::vector<std::uint64_t>& first) {
      return list.span().subspan(first[p], first[p + 1] - first[p]);
    };
    const auto own = part(lists.vertices, lists.first_vertex);
    const auto triangles = part(lists.triangles, lists.first_triangle);
    auto own_memory =
        TRY(context.reserve(own.size() * vertex_bytes(mesh) + triangles.size() * sizeof(glm::uvec3), what));
    mesh::Mesh& piece = pieces[p];
    piece.name = mesh.name;
    piece.origin = mesh.origin;
    piece.material = mesh.material;
    piece.memory = std::move(own_memory);
    piece.positions = gathered_from(mesh.positions, 1, own);
    piece.normals = gathered_from(mesh.normals, 1, own);
    piece.edges = gathered_from(mesh.edges, 1, own);
    for (const mesh::Attribute& attribute : mesh.attributes) {
      piece.attributes.push_back(attribute.without_values());
      piece.attributes.back().values = gathered_from(attribute.values, attribute.stride(), own);
    }
    for (std::uint32_t i = 0; i < own.size(); ++i) new_of_old[own[i]] = i;
    piece.triangles = Buffer<glm::uvec3>(triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const glm::uvec3& t = mesh.triangles[triangles[i]];
      piece.triangles[i] = {new_of_old[t.x], new_of_old[t.y], new_of_old[t.z]};
    }
  }
  return pieces;
}

}  // namespace

Result<SelectedBodies> select_bodies(mesh::Mesh mesh, const BodySelection& options, const Context& context,
                                     OriginalPositions sites) {
  const std::string name = mesh.name;
  return with_body_memory(name, [&] { return keep(std::move(mesh), options, context, std::move(sites)); });
}

Result<void> mark_bodies(mesh::Mesh& mesh, const Context& context, OriginalPositions sites) {
  return with_body_memory(mesh.name, [&] { return mark(mesh, context, std::move(sites)); });
}

Result<std::vector<mesh::Mesh>> split_into_bodies(mesh::Mesh mesh, std::uint64_t most, const Context& context) {
  const std::string name = mesh.name;
  return with_body_memory(name, [&] { return split(std::move(mesh), most, context); });
}

}  // namespace isoextract::edit
