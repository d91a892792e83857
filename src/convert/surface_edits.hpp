// How fields and surfaces are changed on their way, as values of a job. kMembers are the names of their members in
// JSON.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/words.hpp"
#include "edit/pieces.hpp"
#include "edit/smooth.hpp"

namespace isoextract::convert {

enum class BlurKind { gaussian, median };
constexpr auto words_of(BlurKind /*type*/) {
  return std::array{Word{BlurKind::gaussian, "gaussian"}, Word{BlurKind::median, "median"}};
}

// One blur of a field (field/blur.hpp).
struct BlurStep {
  static constexpr std::array kMembers{"kind", "width", "in_world_units"};

  BlurKind kind = BlurKind::gaussian;
  double width = 1;             // of a Gaussian its standard deviation, of a median whole voxels on either side
  bool in_world_units = false;  // of the input; else in voxels

  friend bool operator==(const BlurStep&, const BlurStep&) = default;
};

// The least size of components that stay.
struct LeastPiece {
  static constexpr std::array kMembers{"measure", "amount", "in_world_units"};

  edit::PieceMeasure measure = edit::PieceMeasure::triangles;
  double amount = 0;
  bool in_world_units = false;  // squares or cubes of the unit of the written mesh; else of voxels

  friend bool operator==(const LeastPiece&, const LeastPiece&) = default;
};

// Which pieces of a surface stay (edit/pieces.hpp), and whether each becomes a mesh.
struct PieceChoice {
  static constexpr std::array kMembers{"least", "fill_cavities", "largest", "split"};

  std::optional<LeastPiece> least;
  bool fill_cavities = false;
  std::optional<std::uint64_t> largest;  // 1 or more
  bool split = false;

  [[nodiscard]] bool drops() const { return least || fill_cavities || largest; }
  friend bool operator==(const PieceChoice&, const PieceChoice&) = default;
};

// How far a simplified mesh may be from the mesh that it was.
struct SimplifyBound {
  static constexpr std::array kMembers{"distance", "in_world_units"};

  double distance = 0;
  bool in_world_units = false;  // else in voxels

  friend bool operator==(const SimplifyBound&, const SimplifyBound&) = default;
};

// How many triangles each surface keeps.
struct TriangleCount {
  static constexpr std::array kMembers{"amount", "in_percent"};

  double amount = 0;  // above 0; a whole number, or a percentage of what the surface had, up to 100
  bool in_percent = false;

  friend bool operator==(const TriangleCount&, const TriangleCount&) = default;
};

// With both, it ends where the first of them is reached.
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
  double pass_band = 0.1;  // above 0, below 1

  friend bool operator==(const SmoothChoice&, const SmoothChoice&) = default;
};

// In the order in which they are done.
struct SurfaceEdits {
  static constexpr std::array kMembers{"pieces", "smooth", "simplify"};

  PieceChoice pieces;
  std::optional<SmoothChoice> smooth;
  std::optional<SimplifyChoice> simplify;

  friend bool operator==(const SurfaceEdits&, const SurfaceEdits&) = default;
};

// In the name of a file: the number of a piece, which then has a file of its own.
inline constexpr std::string_view kPieceWord = "{piece}";
// Files that one surface may be split into, and meshes in one file.
inline constexpr std::uint64_t kMostPieceFiles = 1000;
inline constexpr std::uint64_t kMostPieceMeshes = 100000;

}  // namespace isoextract::convert
