// Finds the remaining triangles of a mesh that are near some boxes.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "base/context.hpp"
#include "base/parallel.hpp"
#include "edit/detail/collapse_state.hpp"
#include "mesh/box_tree.hpp"

namespace isoextract::edit {

// Calls visit(t, box, nodes) for each remaining triangle t that may be near the tree's items. `box` is box_of(t), and
// `nodes` hold all items in leaves whose boxes meet it. Triangles whose numbers follow each other are near each other
// in most meshes, so they search the top of the tree together. Several threads call `box_of` and `visit` at once, for
// different triangles. Returns early if the context is cancelled.
template <class BoxOf, class Visit>
void for_each_triangle_near(const mesh::BoxTree& tree, const CollapseState& state, const BoxOf& box_of,
                            const Context& context, const Visit& visit) {
  constexpr std::size_t kGrain = 1 << 12;
  constexpr std::size_t kTogether = 64;
  struct Boxed {
    std::uint32_t triangle;
    mesh::FloatBox box;
  };
  for_each_range(state.corners.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::array<Boxed, kTogether> run;
    for (std::size_t next = begin; next < end && !context.cancelled(); next += kTogether) {
      std::size_t count = 0;
      mesh::FloatBox around;
      for (auto t = static_cast<std::uint32_t>(next); t < std::min(next + kTogether, end); ++t) {
        if (state.gone[t] != 0) continue;
        run[count] = {t, box_of(t)};
        around = around.with(run[count++].box);
      }
      const mesh::BoxTree::Nodes nodes = tree.nodes_near(around);
      if (nodes.span().empty()) continue;
      for (const Boxed& boxed : std::span(run).first(count)) visit(boxed.triangle, boxed.box, nodes.span());
    }
  });
}

}  // namespace isoextract::edit
