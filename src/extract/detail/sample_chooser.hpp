// Decides ambiguous cells by the samples at their corners.
#pragma once

#include <optional>

#include "extract/asymptotic_decider.hpp"
#include "extract/dense_masks.hpp"
#include "extract/detail/cell_drawings.hpp"

namespace isoextract::extract {

template <class T>
class SampleChooser final : public VariantChooser {
 public:
  // `view` shows the region; the lowest samples of cells are relative to it.
  SampleChooser(const CaseTable& table, const InsideRule& rule, const field::ValueScale& scale, bool has_holes,
                const DenseView<T>& view)
      : table_(table), rule_(rule), scale_(scale), has_holes_(has_holes), view_(view) {}

  [[nodiscard]] std::optional<unsigned> variant(unsigned cell_case, const glm::ivec3& p) const override {
    return cell_variant_or_hole(table_, cell_case, rule_, has_holes_, [&](int corner) {
      const glm::ivec3 at = p + direction_step(corner);
      return scale_(static_cast<double>(view_.row(at.y, at.z)[at.x]));
    });
  }

 private:
  const CaseTable& table_;
  InsideRule rule_;
  field::ValueScale scale_;
  bool has_holes_;
  DenseView<T> view_;
};

}  // namespace isoextract::extract
