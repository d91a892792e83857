// Decides which bodies of a surface stay, from the facts of its components. For a mesh in memory (edit/bodies.hpp) and
// for one that comes in parts (edit/partwise_bodies.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <string>
#include <vector>

#include "base/allocation_error.hpp"
#include "base/error.hpp"
#include "edit/bodies.hpp"
#include "mesh/component_facts.hpp"
#include "mesh/components.hpp"
#include "mesh/shells.hpp"

namespace isoextract::edit {

// Bytes for each component: its measures, its nesting and the selection.
inline constexpr std::uint64_t kComponentBytes = sizeof(mesh::ComponentFacts) + sizeof(mesh::Surroundings) + 64;

// The body around each cavity, and the cavity around each body.
struct Nesting {
  static constexpr std::uint32_t kNone = mesh::Components::kNone;

  // For each component, the index of its body: a cavity has the body around it, a body itself. A cavity without a body
  // around it (its material continues beyond the data) is its own body.
  std::vector<std::uint32_t> body;
  // For each body: the cavity that it lies in, or kNone.
  std::vector<std::uint32_t> within;

  // Returns the nesting of components of which none is a cavity: each is a body.
  [[nodiscard]] static Nesting without_cavities(std::size_t components);
  [[nodiscard]] bool is_body(std::size_t i) const { return body[i] == i; }
};

[[nodiscard]] bool has_cavities(std::span<const mesh::ComponentFacts> facts);
// Returns the question whose answer nesting_of() needs.
[[nodiscard]] mesh::ShellQuery shell_query(std::span<const mesh::ComponentFacts> facts);
[[nodiscard]] Nesting nesting_of(std::span<const mesh::ComponentFacts> facts,
                                 const std::vector<mesh::Surroundings>& surroundings);

// Returns the bodies among the components that stay, the largest area first.
[[nodiscard]] std::vector<std::uint32_t> bodies_by_area(std::span<const mesh::ComponentFacts> facts,
                                                        const Nesting& nesting, const std::vector<bool>& stays);

struct BodyChoice {
  std::vector<bool> stays;  // of each component
  BodyFigures figures;      // without the time
};

// `facts` are in the space of options.to_metric; `resolution` is mesh::float32_resolution() of the positions.
[[nodiscard]] BodyChoice choose_bodies(std::span<const mesh::ComponentFacts> facts, const Nesting& nesting,
                                       const BodySelection& options, double resolution);

// Returns work(), or ErrorCode::out_of_memory if it throws std::bad_alloc. `name` is the name of the mesh.
template <class Work>
auto with_body_memory(const std::string& name, const Work& work) -> decltype(work()) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(name + ": the components of its surface need more memory than is available",
                                           {Remedy::use, Setting::parts}));
  }
}

}  // namespace isoextract::edit
