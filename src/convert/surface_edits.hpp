// The edits of fields and surfaces that a job requests. Each kMembers lists the names of a struct's members in JSON, in
// their order.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/enum_words.hpp"
#include "check/mesh_requirement.hpp"
#include "edit/bodies.hpp"
#include "edit/repair.hpp"
#include "edit/smooth.hpp"

namespace isoextract::convert {

enum class BlurKind { gaussian, median };
constexpr auto words_of(BlurKind /*type*/) {
  return std::array{Word{BlurKind::gaussian, "gaussian"}, Word{BlurKind::median, "median"}};
}

// One blur step of a field (field/blur.hpp).
struct BlurStep {
  static constexpr std::array kMembers{"kind", "width", "in_world_units"};

  BlurKind kind = BlurKind::gaussian;
  double size = 1;              // Gaussian: standard deviation; median: whole voxels on either side
  bool in_world_units = false;  // Gaussian only: in units of the input's world, else in voxels

  friend bool operator==(const BlurStep&, const BlurStep&) = default;
};

// Size below which components are removed.
struct MinComponentSize {
  static constexpr std::array kMembers{"measure", "amount", "in_world_units"};

  edit::ComponentMeasure measure = edit::ComponentMeasure::triangles;
  double amount = 0;
  bool in_world_units = false;  // area and volume: in squares or cubes of the written mesh's unit, else of voxels

  friend bool operator==(const MinComponentSize&, const MinComponentSize&) = default;
};

// The bodies and components to keep (edit/bodies.hpp), and whether each body becomes a mesh of its own.
struct PieceChoice {
  static constexpr std::array kMembers{"least", "fill_cavities", "largest", "split"};

  std::optional<MinComponentSize> least;  // removes smaller components
  bool fill_cavities = false;
  std::optional<std::uint64_t> largest;  // keeps this many of the largest bodies, at least 1
  bool split = false;                    // makes each body a mesh of its own

  [[nodiscard]] bool drops() const { return least || fill_cavities || largest; }
  friend bool operator==(const PieceChoice&, const PieceChoice&) = default;
};

// Largest distance of the simplified mesh from the original.
struct SimplifyBound {
  static constexpr std::array kMembers{"distance", "in_world_units"};

  double distance = 0;
  bool in_world_units = false;  // in the written mesh's unit, else in voxels

  friend bool operator==(const SimplifyBound&, const SimplifyBound&) = default;
};

// Target number of triangles of each surface; for labels, of all labels together. More stay if removing them would
// change the topology or flip triangles, or exceed SimplifyChoice::within.
struct TriangleCount {
  static constexpr std::array kMembers{"amount", "in_percent"};

  double amount = 0;  // above 0: a whole number, or a percentage (up to 100) of the surface's triangles
  bool in_percent = false;

  friend bool operator==(const TriangleCount&, const TriangleCount&) = default;
};

// Simplification stops at the bound that it reaches first, if both are set.
struct SimplifyChoice {
  static constexpr std::array kMembers{"within", "triangles"};

  std::optional<SimplifyBound> within;
  std::optional<TriangleCount> triangles;

  friend bool operator==(const SimplifyChoice&, const SimplifyChoice&) = default;
};

struct SmoothChoice {
  static constexpr std::array kMembers{"passes", "method", "pass_band"};

  std::uint64_t passes = 20;  // 1 to edit::kMaxSmoothPasses
  edit::SmoothMethod method = edit::SmoothMethod::taubin;
  double pass_band = 0.1;  // above 0, below 1; unused by SmoothMethod::weighted

  friend bool operator==(const SmoothChoice&, const SmoothChoice&) = default;
};

// The repair of a mesh file (edit/repair.hpp).
struct RepairChoice {
  static constexpr std::array kMembers{"most_hole_edges"};

  std::uint64_t most_hole_edges = edit::kUsualHoleEdges;  // longest boundary loop to fill; 0 fills none

  friend bool operator==(const RepairChoice&, const RepairChoice&) = default;
};

inline constexpr std::string_view kVoxelUnit = "voxel";
inline constexpr std::string_view kWorldUnit = "world";

// The inner wall of closed surfaces (extract/inner_wall.hpp).
struct HollowChoice {
  static constexpr std::array kMembers{"thickness", "unit"};

  double thickness = 0;  // above 0
  // kWorldUnit: the written mesh's unit; kVoxelUnit: the cube root of a voxel's volume; or the name of a LengthUnit
  std::string unit;

  friend bool operator==(const HollowChoice&, const HollowChoice&) = default;
};

// Vertices at equal positions, where sheets of a surface touch (edit/separate_touching.hpp).
enum class Touching {
  apart,  // moves them apart
  keep,
};
constexpr auto words_of(Touching /*type*/) {
  return std::array{Word{Touching::apart, "apart"}, Word{Touching::keep, "keep"}};
}

// Edits of a surface, in the order in which they run. PieceChoice::split is an exception: it takes effect after all
// others.
struct SurfaceEdits {
  static constexpr std::array kMembers{"repair", "pieces", "smooth", "hollow", "simplify", "touching", "require"};

  std::optional<RepairChoice> repair;  // of a mesh file; before it is clipped
  PieceChoice pieces;
  std::optional<SmoothChoice> smooth;
  std::optional<HollowChoice> hollow;
  std::optional<SimplifyChoice> simplify;
  Touching touching = Touching::keep;
  // Properties that each mesh must have as its file stores it; else the conversion fails. With no_self_intersections,
  // an edit first removes self-intersections (edit/untangle.hpp).
  std::vector<check::Requirement> require;

  [[nodiscard]] bool untangles() const {
    return std::ranges::find(require, check::Requirement::no_self_intersections) != require.end();
  }
  friend bool operator==(const SurfaceEdits&, const SurfaceEdits&) = default;
};

// Placeholder in an output name for the number of a body; with PieceChoice::split, each body then gets its own file.
inline constexpr std::string_view kPiecePlaceholder = "{piece}";

// Stand for the number and the name of a label in the name of its file.
inline constexpr std::string_view kLabelPlaceholder = "{label}";
inline constexpr std::string_view kNamePlaceholder = "{name}";
// Limits for one surface: files to split it into, and meshes in one file.
inline constexpr std::uint64_t kMaxPieceFiles = 1000;
inline constexpr std::uint64_t kMostPieceMeshes = 100000;

}  // namespace isoextract::convert
