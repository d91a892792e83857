// Explains in plain sentences what a slicer or a game engine would make of a mesh.
#include <algorithm>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "cli/check_report.hpp"

namespace isoextract::cli {
namespace {

using check::MeshCheck;
using check::Shell;

constexpr std::string_view kSlicer = "slicer";
constexpr std::string_view kEngine = "engine";

std::string size_text(const glm::dvec3& size, double scale, std::string_view unit) {
  return fmt::format("{:.4g} x {:.4g} x {:.4g} {}", size.x * scale, size.y * scale, size.z * scale, unit);
}

class Findings {
 public:
  explicit Findings(const CheckReport& report) : report_(report), check_(report.whole) {}

  std::vector<Finding> run() {
    if (check_.triangles == 0) {
      return {{kSlicer, "There is nothing to print: the mesh has no triangles."},
              {kEngine, "There is nothing to draw: the mesh has no triangles."}};
    }
    tell_boundaries();
    tell_sides();
    tell_overlaps();
    tell_bodies();
    tell_shading();
    if (slicers_.empty()) {
      const std::uint64_t touching = check_.topology.nonmanifold_vertices;
      slicer(touching == 0
                 ? "It needs no repair: the mesh is closed, manifold, faces outward and does not intersect itself."
                 : fmt::format(
                       "It needs no repair: the mesh is closed, faces outward and does not intersect itself; surfaces "
                       "touch at {}, which slicers accept.",
                       counted(touching, "vertex", "vertices")));
    }
    tell_size();
    slicers_.insert(slicers_.end(), engines_.begin(), engines_.end());
    return std::move(slicers_);
  }

 private:
  void slicer(std::string text) { slicers_.push_back({kSlicer, std::move(text)}); }
  void engine(std::string text) { engines_.push_back({kEngine, std::move(text)}); }

  void tell_boundaries() {
    const auto& topology = check_.topology;
    if (topology.open_edges > 0 && check_.welded && check_.welded->open_edges == 0) {
      slicer("It welds vertices at equal positions, which closes the mesh; --weld reports on the welded mesh.");
      engine("It keeps vertices at equal positions apart: seams of colors, textures or normals.");
    } else if (topology.open_edges > 0) {
      const auto* longest = &*std::ranges::max_element(check_.loops, {}, &check::BoundaryLoop::length);
      slicer(fmt::format("It fills {} in its own way, or refuses the mesh; the longest boundary loop measures {:.4g}.",
                         counted(check_.loops.size(), "hole"), longest->length));
      engine("Through the holes it shows the back of the surface, or nothing: draw both sides of the triangles.");
    }
    if (topology.nonmanifold_edges > 0) {
      slicer(fmt::format("It must guess the inside at {} with more than two triangles.",
                         counted(topology.nonmanifold_edges, "edge")));
    }
    if (topology.nonmanifold_edges + topology.nonmanifold_vertices > 0) {
      engine("Subdivision, unwrapping and collision solids need a manifold and may refuse this mesh.");
    }
  }

  void tell_sides() {
    const std::uint64_t inside_out = check_.count(Shell::inside_out);
    if (check_.topology.misoriented_edges > 0) {
      slicer(fmt::format("It must flip triangles: neighbors have opposite winding at {}.",
                         counted(check_.topology.misoriented_edges, "edge")));
    }
    if (inside_out > 0) {
      slicer(fmt::format("It treats {}: flip the triangles.",
                         counted(inside_out, "component that is inside out as a cavity",
                                 "components that are inside out as cavities")));
      engine("It shows the inside of components that are inside out, if it draws only one side of triangles.");
    }
    if (const std::uint64_t undecided = check_.count(Shell::undecided); undecided > 0) {
      slicer(
          fmt::format("It treats {} within an open component as cavities; close the mesh to find out whether they are.",
                      counted(undecided, "component that faces inward", "components that face inward")));
    }
    if (check_.topology.misoriented_edges > 0) {
      engine(fmt::format("It does not draw some triangles: neighbors have opposite winding at {}.",
                         counted(check_.topology.misoriented_edges, "edge")));
    }
  }

  void tell_overlaps() {
    const auto& found = check_.intersections;
    if (found.pairs > 0) {
      slicer(
          fmt::format("It finds {}{} of triangles that intersect: walls inside walls, and slices with crossing "
                      "outlines.",
                      found.at_least ? "more than " : "", counted(found.pairs, "pair")));
    }
    if (found.in_one_plane + found.duplicate_triangles > 0) {
      engine("Triangles that overlap in one plane flicker.");
    }
    if (check_.count(Shell::nested) > 0) {
      slicer(fmt::format("It fills {} inside {} twice, or leaves a cavity there.",
                         counted(check_.count(Shell::nested), "body", "bodies"),
                         check_.count(Shell::nested) == 1 ? "another" : "others"));
    }
  }

  void tell_bodies() {
    const std::uint64_t bodies =
        check_.components.size() - check_.count(Shell::cavity) - check_.count(Shell::undecided);
    if (bodies > 1) {
      std::uint64_t smallest = check_.triangles;
      for (const check::Component& component : check_.components) {
        if (component.shell != Shell::cavity && component.shell != Shell::undecided)
          smallest = std::min(smallest, component.triangles);
      }
      slicer(fmt::format("It prints {} separate bodies; the smallest has {}.", bodies, counted(smallest, "triangle")));
    }
  }

  void tell_shading() {
    if (check_.intersections.zero_area_triangles > 0) {
      engine(fmt::format("It cannot shade {} without area: they have no normal.",
                         counted(check_.intersections.zero_area_triangles, "triangle")));
    }
    if (check_.normals && check_.normals->against > 0) {
      engine(fmt::format("It shades {:.2g} % of the corners from the wrong side: their normals point into the mesh.",
                         100 * check_.normals->flipped_fraction()));
    }
    if (!report_.has_normals) {
      engine("It computes its own normals: the file has none.");
    }
  }

  void tell_size() {
    const glm::dvec3 size = check_.bounds.max - check_.bounds.min;
    if (report_.is_gltf) {
      engine(fmt::format("The mesh measures {}.", size_text(size, 1, "m")));
      slicer(fmt::format("The mesh measures {}, if the slicer reads glTF in meters.", size_text(size, 1000, "mm")));
      return;
    }
    std::string besides;
    if (const auto& unit = report_.unit) {
      const double scale = convert::unit_ratio(*unit, *convert::find_length_unit("mm"));
      besides =
          scale == 1 ? ", as the file states" : fmt::format("; the file states {}: scale by {:g}", unit->name, scale);
    } else if (std::max({size.x, size.y, size.z}) < 1) {
      besides = "; if the numbers are meters, scale by 1000";
    }
    slicer(fmt::format("It reads the numbers as millimeters: {}{}.", size_text(size, 1, "mm"), besides));
  }

  const CheckReport& report_;
  const MeshCheck& check_;
  std::vector<Finding> slicers_;
  std::vector<Finding> engines_;
};

}  // namespace

std::vector<Finding> findings_of(const CheckReport& report) { return Findings(report).run(); }

}  // namespace isoextract::cli
