// Who takes the meshes of a conversion where they are not written to its files.
#pragma once

#include <vector>

#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

class MeshSink {
 public:
  virtual ~MeshSink() = default;

  // The surfaces of one output: at least one, in the order of its iso values, as they would be written: placed,
  // simplified, verified. Those that EmptyPolicy::skip leaves out are not among them; where it leaves out all of them
  // the output is passed over, and no old file is removed. Where there are several iso values, each mesh is named after
  // its own. Told on the thread of the conversion, which fails as this does. The meshes keep what they have reserved.
  [[nodiscard]] virtual Result<void> take(const OutputFileJob& output, std::vector<mesh::Mesh> surfaces) = 0;
};

}  // namespace isoextract::convert
