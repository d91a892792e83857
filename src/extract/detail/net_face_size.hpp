// The sizes of the faces of a surface net.
#pragma once

#include <array>
#include <cstdint>

#include <glm/glm.hpp>

#include "extract/detail/near_points.hpp"
#include "extract/detail/net_memory.hpp"

namespace isoextract::extract {

struct NetFaceSize {
  glm::vec3 area;  // as a normal toward the upper side
  float volume;    // between the voxel face and the two triangles that the mesh will have, positive above the face
};

class NetFaceSizes {
 public:
  // `offsets` has the offset of each point from its corner, in grid steps, and one unused element at the end, since
  // load() reads 16 bytes. `output_from_index` is an invertible map; it decides which diagonal divides a face.
  NetFaceSizes(const NetArray<glm::vec3>& offsets, const glm::dmat3& output_from_index);

  // Returns the size of the face that is perpendicular to `axis` and has its first point at `place`.
  [[nodiscard]] NetFaceSize of(const NearPoints& near, int place, int axis) const {
    if (axis == 0) return across<0>(near, place);
    return axis == 1 ? across<1>(near, place) : across<2>(near, place);
  }

 private:
  template <int kAxis>
  [[nodiscard]] NetFaceSize across(const NearPoints& near, int place) const;

  const NetArray<glm::vec3>& offsets_;
  glm::mat3 output_area_;  // maps areas, up to a constant factor
  bool is_stretched_;
};

}  // namespace isoextract::extract
