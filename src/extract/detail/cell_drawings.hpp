// A case table in the form that inner loops read: one short record a case, triangles as bytes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "extract/cell_tables.hpp"

namespace isoextract::extract {

// Chooses the variant of cells whose case alone does not decide it: of ambiguous cells, and of all cells if samples may
// be NaN.
class VariantChooser {
 public:
  virtual ~VariantChooser() = default;
  // Returns the variant (CaseTable) of the cell whose lowest sample is `p`, or nullopt if the cell is left out.
  [[nodiscard]] virtual std::optional<unsigned> variant(unsigned cell_case, const glm::ivec3& p) const = 0;
};

class CellDrawings {
 public:
  using Triangle = std::array<std::uint8_t, 4>;  // three edge names and a padding byte

  // The triangles first to first + count - 1.
  struct Drawing {
    std::uint16_t first = 0;
    std::uint8_t count = 0;
    bool decided = false;   // only in by_case_: the VariantChooser chooses the variant
    bool left_out = false;  // the VariantChooser left the cell out
  };

  // `mirrored` reverses the winding. `decide_all`: the VariantChooser decides every cell. `names` replace the numbers
  // of the table's edges in triangles; without them, triangles hold edge numbers.
  CellDrawings(const CaseTable& table, bool mirrored, bool decide_all, std::span<const std::uint8_t> names = {});

  [[nodiscard]] int directions() const { return directions_; }
  // Returns the edges of the table, as bits, whose ends are on different sides.
  [[nodiscard]] std::uint32_t crossed_edges(unsigned cell_case) const { return crossed_edges_[cell_case]; }

  // Returns the triangles of the cell whose lowest sample is origin + p.
  [[nodiscard]] Drawing of(unsigned cell_case, const VariantChooser& decider, const glm::ivec3& origin,
                           const glm::ivec3& p) const {
    const Drawing drawing = by_case_[cell_case];
    if (!drawing.decided) return drawing;
    const auto variant = decider.variant(cell_case, origin + p);
    return variant ? by_variant_[*variant] : Drawing{.left_out = true};
  }

  // Writes the triangles of a cell to `out` and returns their end. `numbers` maps edge names to vertex numbers. It is
  // an array, because with a pointer GCC vectorizes the loop, which pays only from 16 triangles on.
  template <class Numbers>
  glm::uvec3* write(const Drawing& drawing, const Numbers& numbers, glm::uvec3* out) const {
    const Triangle* triangle = triangles_.data() + drawing.first;
    for (unsigned t = 0; t < drawing.count; ++t, ++triangle) {
      *out++ = glm::uvec3(numbers[(*triangle)[0]], numbers[(*triangle)[1]], numbers[(*triangle)[2]]);
    }
    return out;
  }

 private:
  int directions_;
  std::array<Drawing, 256> by_case_;
  std::array<std::uint32_t, 256> crossed_edges_{};
  std::vector<Drawing> by_variant_;
  std::vector<Triangle> triangles_;
};

// Counts over the cells of a row or a site.
struct CellCounts {
  std::uint64_t triangles = 0;
  std::uint64_t left_out = 0;  // cells

  void add(const CellDrawings::Drawing& drawing) {
    triangles += drawing.count;
    left_out += drawing.left_out ? 1 : 0;
  }
};

}  // namespace isoextract::extract
