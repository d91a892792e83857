// The table of extraction methods: names, properties of their surfaces (traits), and the function that runs each on the
// CPU. Options, help, bench, stability and verification read this table, so a new method is a new row.
//
// Code that measures or compares surfaces checks the traits first. If a measurement does not apply to a method, the
// code reports the reason instead of a figure (the why_no_...() function of the missing trait).
//
// A new method adds itself to Method and gets a row here. It must meet the guarantees at the top of extractor.hpp, and
// skip bricks that iso cannot cross. A method that works cell by cell has a case table. The top of cell_tables.hpp
// documents corner order and bit order with a drawing; the table's .cpp file cites the papers. A test checks
// orientation and closure of every case. If the GPU draws the method, pipeline_of (src/gpu/detail/gpu_surface.cpp)
// names its pipeline.
//
// tests/unit/bench/method_traits_test.cpp measures every trait. The suites of tests/unit/extract run over all rows, or
// over the rows with a trait (tests/support/methods.hpp). exact_topology_test.cpp does not compile until sample_joins()
// has a case for the new method. Add tests of guarantees that only the new method gives.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::extract {

struct ExtractOptions;
struct Extraction;

enum class Method {
  mc,            // marching cubes, with the topology of the trilinear interpolant (asymptotic_decider.hpp)
  mt,            // marching tetrahedra, six in each cell (cell_tables.hpp)
  voxels,        // the exposed faces of inside samples, each a box (voxels.hpp)
  surface_nets,  // the same faces with their corners moved to smooth positions (detail/net_points.hpp)
};

struct MethodTraits {
  // Every surface vertex lies strictly inside one grid edge whose ends are on different sides; no edge has two
  // vertices, unless NanPolicy::hole duplicates its vertex. Cap vertices lie at samples; their edge key has direction
  // 0. Methods without this trait have no edge keys.
  bool vertices_on_edges = true;
  // Grid edges with vertices run along the axes only, so no diagonal divides the cell faces (Method::mt divides each
  // into two triangles).
  bool axis_edges_only = true;
  // The surface follows the field between its samples, with an error of second order in the spacing. A vertex on an
  // edge lies at the linear crossing, at least the margin of edge_geometry.hpp away from the ends.
  bool follows_interpolant = true;
  // Normals can come from the gradient of the field (ExtractOptions::smooth_normals).
  bool gradient_normals = true;
  // The surface is closed at the data boundary, too: ExtractOptions::cap has no effect, NanPolicy::hole is an error.
  bool always_closed = false;

  friend bool operator==(const MethodTraits&, const MethodTraits&) = default;
};

struct MethodInfo {
  Method method = Method::mc;
  std::string_view id;     // "mc"
  std::string_view title;  // "marching cubes"
  std::string_view help;   // text in the help: "marching tetrahedra (six in each cell)"
  MethodTraits traits;
  // Runs the method on the CPU, for dense and sparse fields. Extractor::has() tells which methods a device has.
  Result<Extraction> (*run_on_cpu)(const field::ScalarField& field, const ExtractOptions& options,
                                   const Context& context) = nullptr;
};

// Extracts cell by cell with a case table (cell_tables.hpp): mc and mt.
[[nodiscard]] Result<Extraction> extract_by_cells(const field::ScalarField& field, const ExtractOptions& options,
                                                  const Context& context);

// Extracts the exposed faces of the boxes around inside samples (voxels.hpp).
[[nodiscard]] Result<Extraction> extract_voxels(const field::ScalarField& field, const ExtractOptions& options,
                                                const Context& context);

// Extracts the faces of extract_voxels() with smoothed corners (detail/net_points.hpp).
[[nodiscard]] Result<Extraction> extract_surface_nets(const field::ScalarField& field, const ExtractOptions& options,
                                                      const Context& context);

// In the order of the enum Method.
inline constexpr std::array kMethods{
    MethodInfo{.method = Method::mc,
               .id = "mc",
               .title = "marching cubes",
               .help = "marching cubes",
               .traits = {.vertices_on_edges = true,
                          .axis_edges_only = true,
                          .follows_interpolant = true,
                          .gradient_normals = true},
               .run_on_cpu = extract_by_cells},
    MethodInfo{.method = Method::mt,
               .id = "mt",
               .title = "marching tetrahedra",
               .help = "marching tetrahedra (six in each cell)",
               .traits = {.vertices_on_edges = true,
                          .axis_edges_only = false,
                          .follows_interpolant = true,
                          .gradient_normals = true},
               .run_on_cpu = extract_by_cells},
    MethodInfo{.method = Method::voxels,
               .id = "voxels",
               .title = "voxels",
               .help = "a solid box around each sample inside, always closed, with flat faces",
               .traits = {.vertices_on_edges = false,
                          .axis_edges_only = false,
                          .follows_interpolant = false,
                          .gradient_normals = false,
                          .always_closed = true},
               .run_on_cpu = extract_voxels},
    MethodInfo{.method = Method::surface_nets,
               .id = "surface-nets",
               .title = "surface nets",
               .help = "the surface between inside and outside samples, or around each label, "
                       "smooth and always closed",
               .traits = {.vertices_on_edges = false,
                          .axis_edges_only = false,
                          .follows_interpolant = false,
                          .gradient_normals = false,
                          .always_closed = true},
               .run_on_cpu = extract_surface_nets},
};

[[nodiscard]] constexpr const MethodInfo& method_info(Method method) {
  return kMethods[static_cast<std::size_t>(method)];
}

[[nodiscard]] constexpr auto method_ids() {
  std::array<std::string_view, kMethods.size()> ids{};
  for (std::size_t m = 0; m < ids.size(); ++m) ids[m] = kMethods[m].id;
  return ids;
}

constexpr auto words_of(Method /*type*/) {
  std::array<Word<Method>, kMethods.size()> words{};
  for (std::size_t m = 0; m < words.size(); ++m) words[m] = {kMethods[m].method, kMethods[m].id};
  return words;
}

// Returns the methods with follows_interpolant, in the order of the enum. Commands that measure errors or crossings use
// them by default.
[[nodiscard]] std::vector<MethodInfo> interpolant_methods();

// Each returns why surfaces of the method lack the property named at the right, as a sentence without full stop that
// starts with the method's title; "" if they have the property.
[[nodiscard]] std::string why_no_edge_keys(const MethodInfo& method);         // edge keys
[[nodiscard]] std::string why_no_crossings(const MethodInfo& method);         // vertices at the iso value
[[nodiscard]] std::string why_no_gradient_normals(const MethodInfo& method);  // normals from gradients
[[nodiscard]] std::string why_no_holes(const MethodInfo& method);             // holes around NaN samples

// Fails with ErrorCode::usage if `options` ask for something that the method does not have: edge keys, normals from
// gradients, or holes.
[[nodiscard]] Result<void> check_method(const MethodInfo& method, const ExtractOptions& options);

}  // namespace isoextract::extract
