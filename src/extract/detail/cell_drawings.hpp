// A case table in the form the extractors' inner loops read: one short record a case, triangles as bytes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "extract/cell_tables.hpp"

namespace isoextract::extract {

// Decides what a cell draws whose case does not say it alone: ambiguous ones, and all where samples can be NaN.
class CellDecider {
 public:
  virtual ~CellDecider() = default;
  // The variant (CaseTable) drawn by the cell whose lowest sample is `p`; nothing where the cell is left out.
  [[nodiscard]] virtual std::optional<unsigned> variant(unsigned cell_case, const glm::ivec3& p) const = 0;
};

class CellDrawings {
 public:
  using Triangle = std::array<std::uint8_t, 4>;  // three names of edges and a filling byte

  // Triangles first .. first + count - 1.
  struct Drawing {
    std::uint16_t first = 0;
    std::uint8_t count = 0;
    bool decided = false;   // of a case: the decider says which variant
    bool left_out = false;  // by the decider
  };

  // `mirrored` turns triangles over. `decide_all`: the decider is asked about every cell. `names` are what triangles
  // call the table's edges; without them these are called by their numbers.
  CellDrawings(const CaseTable& table, bool mirrored, bool decide_all, std::span<const std::uint8_t> names = {});

  [[nodiscard]] int directions() const { return directions_; }
  // The set of the table's edges whose ends are on different sides.
  [[nodiscard]] std::uint32_t crossed_edges(unsigned cell_case) const { return crossed_edges_[cell_case]; }

  // What the cell whose lowest sample is origin + p draws.
  [[nodiscard]] Drawing of(unsigned cell_case, const CellDecider& decider, const glm::ivec3& origin,
                           const glm::ivec3& p) const {
    const Drawing drawing = by_case_[cell_case];
    if (!drawing.decided) return drawing;
    const auto variant = decider.variant(cell_case, origin + p);
    return variant ? by_variant_[*variant] : Drawing{.left_out = true};
  }

  // Writes a cell's triangles to `out` and returns their end. `numbers` are those of vertices, by what triangles call
  // their edges: an array, since through a pointer GCC vectorises the loop, which only pays from 16 triangles on.
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

// What the cells of a row or a site draw together.
struct CellCounts {
  std::uint64_t triangles = 0;
  std::uint64_t left_out = 0;  // cells

  void add(const CellDrawings::Drawing& drawing) {
    triangles += drawing.count;
    left_out += drawing.left_out ? 1 : 0;
  }
};

}  // namespace isoextract::extract
