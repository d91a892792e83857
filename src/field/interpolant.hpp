// The field between its samples: value and gradient at any position.
//
// trilinear: the interpolant whose surface marching cubes approximates.
// tricubic: the tensor product of Catmull-Rom splines (Catmull and Rom, "A class of local interpolating splines",
// 1974). It equals the interpolant of Lekien and Marsden, "Tricubic interpolation in three dimensions", Int. J. Numer.
// Meth. Engng 63, 2005, with all derivatives, the mixed ones too, by central differences; at the border of dense data
// these become one-sided differences of the same order. It is smooth across cells, so it shows what the creases between
// trilinear cells cost.
#pragma once

#include <array>
#include <optional>
#include <span>

#include <glm/glm.hpp>

#include "base/words.hpp"
#include "field/scalar_field.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::field {

enum class Interpolation { trilinear, tricubic };
constexpr auto words_of(Interpolation /*type*/) {
  return std::array{Word{Interpolation::trilinear, "trilinear"}, Word{Interpolation::tricubic, "tricubic"}};
}

struct Interpolated {
  double value = 0;          // in the field's own values, less the base; NaN where a sample it depends on is not finite
  glm::dvec3 gradient{0.0};  // of those values, per index step
};

struct SampleRange {
  double low = 0;
  double high = 0;
};

class Interpolant {
 public:
  // `field` must outlive this; dense ones need two samples along each axis. `base` is taken off each sample before they
  // are summed up: differences from it keep their digits where it is large and they are small.
  Interpolant(const ScalarField& field, Interpolation interpolation, double base = 0);

  // The lowest sample of the cell whose polynomial a position has.
  [[nodiscard]] glm::ivec3 cell_of(const glm::dvec3& index) const;

  // Looks at one position after the other, in index space. Keeps the samples of the last cell, because neighbours in a
  // sequence mostly share it: one a thread. Beyond dense data the border cell's polynomial goes on.
  class Cursor {
   public:
    explicit Cursor(const Interpolant& interpolant) : interpolant_(interpolant) {}
    [[nodiscard]] Interpolated operator()(const glm::dvec3& index);

    // The polynomial of one cell, at `t` from the lowest sample of the cell. On a face of the cell the value is that of
    // the cell beyond it, bit for bit.
    [[nodiscard]] Interpolated in_cell(const glm::ivec3& cell, const glm::dvec3& t);

    // Least and greatest of the samples that the polynomial depends on; nothing where one of them is not finite.
    [[nodiscard]] std::optional<SampleRange> range(const glm::ivec3& cell);

    // Of a trilinear interpolant in one cell: no second derivative in any direction is greater, per index step squared.
    // Nothing where a sample is not finite, and for the other interpolants.
    [[nodiscard]] std::optional<double> greatest_bend(const glm::ivec3& cell);

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
  // Reads the samples around a cell into `values`, those beyond dense data as 0, which are not in `range`. False if one
  // is not finite.
  [[nodiscard]] bool load(const glm::ivec3& cell, std::span<double> values, SampleRange& range) const;

  const ScalarField& field_;
  Interpolation interpolation_;
  double base_;
  std::optional<SparseLookup> lookup_;
};

}  // namespace isoextract::field
