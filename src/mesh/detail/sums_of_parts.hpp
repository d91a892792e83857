// Areas and volumes of a mesh that comes in parts, and of its components, with the rounding of a mesh in memory.
//
// Sums are made in ranges of consecutive triangles, which may begin and end in different parts. If ranks share the
// mesh, a rank may begin within a range. It does not sum this first, incomplete range but keeps its triangles, because
// its sum continues that of the rank before. append() does so.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/component_facts.hpp"
#include "mesh/detail/triangle_sums.hpp"
#include "mesh/metrics.hpp"
#include "mesh/partwise_components.hpp"

namespace isoextract::mesh {

class SumsOfParts {
 public:
  // `triangles` is their number in the whole mesh. `what` starts messages about memory. With `is_shared`, the parts are
  // those of one rank, and `facts` get no sums before append().
  SumsOfParts(std::uint64_t triangles, bool is_shared, std::string what, const Context& context);

  // Adds the parts in order, and sums of completed chunks to the facts of their components. Fails with
  // ErrorCode::out_of_memory.
  [[nodiscard]] Result<void> add(const LocalPart& part, const SumSpace& space, const glm::dvec3& origin,
                                 std::vector<ComponentFacts>& facts);

  // Returns the sums of one rank, for append().
  [[nodiscard]] std::string packed() const;
  // Adds the sums of the next rank, whose triangles follow those of the ranks before. Fails with
  // ErrorCode::out_of_memory.
  [[nodiscard]] Result<void> append(std::string_view packed, const SumSpace& space, const glm::dvec3& origin,
                                    std::vector<ComponentFacts>& facts);

  // Adds the last chunk to the facts, and returns the size of the mesh. Call once, last.
  [[nodiscard]] MeshSize finish(const glm::dvec3& origin, std::vector<ComponentFacts>& facts);

 private:
  // A triangle of an incomplete first range.
  struct HeadTriangle {
    std::array<glm::vec3, 3> corners;
    glm::uvec3 same{0, 1, 2};  // the first corner with the vertex of each corner
    std::uint32_t component = 0;
  };
  // The numbers of a rank's triangles in the mesh.
  struct Numbers {
    std::uint64_t first = 0;
    std::uint64_t end = 0;
    // The ends of the incomplete first range and chunk; `first` if they are complete.
    std::uint64_t range_head = 0;
    std::uint64_t chunk_head = 0;
  };

  void begin_numbers(std::uint64_t first);
  void keep_head(const LocalPart& part);
  void add_ranges(const LocalPart& part, const SumSpace& space);
  void add_chunks(const LocalPart& part, const SumSpace& space, const glm::dvec3& origin,
                  std::vector<ComponentFacts>& facts);
  [[nodiscard]] Result<void> take_memory(std::uint64_t bytes);

  std::uint64_t triangles_;
  bool is_shared_;
  std::string what_;
  Context context_;
  Reservation memory_;

  std::vector<std::uint64_t> range_ends_;  // of the ranges of reduce_ranges()
  std::vector<MeshSize> ranges_;           // of completed ranges
  MeshSize open_range_;                    // of the range that continues in the next part
  std::vector<ComponentSum> open_chunk_;   // of the chunk that continues in the next part

  // Used if ranks share the mesh:
  Numbers numbers_;
  std::vector<HeadTriangle> head_;
  std::vector<ComponentSum> chunks_;         // the sums of completed chunks, one chunk after the other
  std::vector<std::uint32_t> chunk_counts_;  // how many sums each of them has
};

}  // namespace isoextract::mesh
