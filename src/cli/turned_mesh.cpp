#include "cli/turned_mesh.hpp"

namespace isoextract::cli {

void turn_y_up_to_z_up(mesh::Mesh& mesh) {
  const auto turn = [](auto& p) { p = {p.x, -p.z, p.y}; };
  turn(mesh.origin);
  for (glm::vec3& p : mesh.positions) turn(p);
}

}  // namespace isoextract::cli
