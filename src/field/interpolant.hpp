// The field between its samples: value and gradient at any position.
//
// trilinear: the interpolant whose isosurface marching cubes approximates.
// tricubic: the tensor product of Catmull-Rom splines (Catmull and Rom, "A class of local interpolating splines",
// 1974). It equals the interpolant of Lekien and Marsden, "Tricubic interpolation in three dimensions", Int. J. Numer.
// Meth. Engng 63, 2005, with central differences for all derivatives, also the mixed ones. At the boundary of dense
// data it uses one-sided differences of the same order. Its gradient is continuous across cells, so a comparison of
// both interpolants shows the error that the creases between trilinear cells cause.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include <glm/glm.hpp>

#include "base/enum_words.hpp"
#include "field/scalar_field.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::field {

enum class Interpolation { trilinear, tricubic };
constexpr auto words_of(Interpolation /*type*/) {
  return std::array{Word{Interpolation::trilinear, "trilinear"}, Word{Interpolation::tricubic, "tricubic"}};
}

struct Interpolated {
  double value = 0;          // scaled value minus the base; NaN if a sample that it depends on is not finite
  glm::dvec3 gradient{0.0};  // of the value, per index step
};

// The least and the greatest of some samples: scaled values minus the base.
struct SampleRange {
  double low = 0;
  double high = 0;
};

class Interpolant {
 public:
  // `field` must outlive this object; a dense field needs two samples along each axis. `base` is subtracted from each
  // sample before the weighted sum, which preserves the digits of small differences from a large base.
  // The caller reserves bytes().
  Interpolant(const ScalarField& field, Interpolation interpolation, double base = 0);

  // Returns the memory that an Interpolant of `field` takes to find sparse blocks.
  [[nodiscard]] static std::uint64_t bytes(const ScalarField& field);

  // Returns the lowest sample of the cell whose polynomial applies at `index`. Takes the first cell along an axis on
  // which `index` is NaN.
  [[nodiscard]] glm::ivec3 cell_of(const glm::dvec3& index) const;

  // Evaluates positions in index space, one after the other. Keeps the samples of the last cell, because consecutive
  // positions often share it. Use one cursor per thread. Outside dense data it extends the polynomial of the boundary
  // cell. At NaN the value is NaN.
  class Cursor {
   public:
    explicit Cursor(const Interpolant& interpolant) : interpolant_(interpolant) {}
    [[nodiscard]] Interpolated operator()(const glm::dvec3& index);

    // Evaluates the polynomial of one cell at `t` in [0, 1]^3 from its lowest sample. On a face both adjacent cells
    // give the same value, bit for bit, if all samples of both are finite.
    [[nodiscard]] Interpolated evaluate_in_cell(const glm::ivec3& cell, const glm::dvec3& t);

    // Returns the range of the samples that the polynomial depends on, or nothing if one of them is not finite.
    [[nodiscard]] std::optional<SampleRange> range(const glm::ivec3& cell);

    // Returns an upper bound of the trilinear interpolant's second derivative in any direction within one cell, per
    // index step squared. Returns nothing for tricubic, or if a sample is not finite.
    [[nodiscard]] std::optional<double> max_second_derivative(const glm::ivec3& cell);

   private:
    static constexpr int kMaxSamples = 4 * 4 * 4;

    void move_to(const glm::ivec3& cell);

    const Interpolant& interpolant_;
    glm::ivec3 cell_{0};
    bool loaded_ = false;
    bool finite_ = false;
    SampleRange range_;
    std::array<double, kMaxSamples> values_{};  // x fastest
  };

 private:
  // Reads the stencil of a cell into `values`. Positions outside dense data become 0 and do not count in `range`.
  // Returns false if a sample is not finite.
  [[nodiscard]] bool load(const glm::ivec3& cell, std::span<double> values, SampleRange& range) const;

  const ScalarField& field_;
  Interpolation interpolation_;
  double base_;
  std::optional<SparseLookup> lookup_;
};

}  // namespace isoextract::field
