// The methods of extraction: what they are called, what can be said of the surfaces that they make, and where their run
// is made. A row of the table is a method: options, help, bench, stability and verification know it by that.
//
// Who measures or compares surfaces asks the traits. What does not hold for a method is told as not applicable, by the
// sentences below, and not measured.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/words.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::extract {

struct ExtractOptions;
struct Extraction;

enum class Method {
  mc,            // marching cubes, with the topology of the trilinear interpolant (asymptotic_decider.hpp)
  mt,            // marching tetrahedra, six a cell (cell_tables.hpp)
  voxels,        // the exposed faces of the samples inside, each a box (voxels.hpp)
  surface_nets,  // the same faces with their corners moved to smooth places (detail/net_points.hpp)
};

struct MethodTraits {
  // Every vertex lies strictly within one edge of the grid whose ends are on two sides, no two within the same one
  // (but where NanPolicy::hole parts them), and those of a cap stand at samples. Only such vertices have edge keys.
  bool vertices_on_edges = true;
  // Those edges run along the axes: what is drawn in a face of a cell is a polygon, not two triangles.
  bool axis_edges_only = true;
  // The surface is that of the field between its samples, with an error of second order in the spacing; a vertex on an
  // edge stands where the field is iso.
  bool follows_interpolant = true;
  // There are normals from the field's gradient (ExtractOptions::smooth_normals).
  bool gradient_normals = true;
  // The surface is closed at the border of the data as well: there is no cap, and no hole.
  bool always_closed = false;

  friend bool operator==(const MethodTraits&, const MethodTraits&) = default;
};

struct MethodInfo {
  Method method = Method::mc;
  std::string_view id;     // "mc"
  std::string_view title;  // "marching cubes"
  std::string_view help;   // how the help lists it: "marching tetrahedra with six a cell"
  MethodTraits traits;
  // The run on the CPU, for dense and for sparse fields. Which methods a device has, the device's extractor says
  // (Extractor::has).
  Result<Extraction> (*run_on_cpu)(const field::ScalarField& field, const ExtractOptions& options,
                                   const Context& context) = nullptr;
};

// Cell by cell, by a table of cases (cell_tables.hpp).
[[nodiscard]] Result<Extraction> extract_by_cells(const field::ScalarField& field, const ExtractOptions& options,
                                                  const Context& context);

// The boxes of the samples inside (voxels.hpp).
[[nodiscard]] Result<Extraction> extract_voxels(const field::ScalarField& field, const ExtractOptions& options,
                                                const Context& context);

// The same faces, smooth (detail/net_points.hpp).
[[nodiscard]] Result<Extraction> extract_surface_nets(const field::ScalarField& field, const ExtractOptions& options,
                                                      const Context& context);

// In the order of the enum.
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
               .help = "marching tetrahedra with six a cell",
               .traits = {.vertices_on_edges = true,
                          .axis_edges_only = false,
                          .follows_interpolant = true,
                          .gradient_normals = true},
               .run_on_cpu = extract_by_cells},
    MethodInfo{.method = Method::voxels,
               .id = "voxels",
               .title = "voxels",
               .help = "voxels: a solid box around each sample inside, always closed, with flat faces",
               .traits = {.vertices_on_edges = false,
                          .axis_edges_only = false,
                          .follows_interpolant = false,
                          .gradient_normals = false,
                          .always_closed = true},
               .run_on_cpu = extract_voxels},
    MethodInfo{.method = Method::surface_nets,
               .id = "surface-nets",
               .title = "surface nets",
               .help = "surface nets: the border between the samples inside and those outside, or of each label, "
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

// Those whose surface follows the field, in the order of the enum: what is compared by errors and crossings where
// nobody names methods.
[[nodiscard]] std::vector<MethodInfo> following_methods();

// Why a question cannot be put to the surfaces of a method, as a sentence without its full stop that begins with the
// method's title; empty where it can.
[[nodiscard]] std::string why_no_edges(const MethodInfo& method);             // no edges to compare vertices by
[[nodiscard]] std::string why_no_crossings(const MethodInfo& method);         // no crossings to compare vertices with
[[nodiscard]] std::string why_no_gradient_normals(const MethodInfo& method);  // no normals from gradients
[[nodiscard]] std::string why_no_holes(const MethodInfo& method);             // no holes where samples are not numbers

// Fails with ErrorCode::usage where `options` ask for what the method does not have: edge keys without vertices on
// edges, normals from gradients, holes.
[[nodiscard]] Result<void> check_method(const MethodInfo& method, const ExtractOptions& options);

}  // namespace isoextract::extract
