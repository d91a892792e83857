// Who takes the meshes of a conversion where they are not written to its files.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_packing.hpp"

namespace isoextract::convert {

// The surfaces of one output: at least one, in the order of its iso values, as they would be written: placed,
// simplified, verified. Those that EmptyPolicy::skip leaves out are not among them; where it leaves out all of them the
// output is passed over, and no old file is removed. Where there are several iso values, each mesh is named after its
// own. The meshes keep what they have reserved.
struct HandedMeshes {
  OutputFileJob output;
  std::vector<double> isos;  // one a mesh
  std::vector<mesh::Mesh> meshes;
  mesh_io::MeshPacking packing;  // how they are to be packed
  std::string placement = {};    // mesh_io::MeshWriteOptions has it
};

struct Source;

class MeshSink {
 public:
  virtual ~MeshSink() = default;

  // Whether what it gets is on its way to the files that the job names, so that it is to be seen first of all that they
  // can be written.
  [[nodiscard]] virtual bool writes_files() const { return true; }

  // Told on the thread of the conversion, which fails as this does.
  [[nodiscard]] virtual Result<void> take(HandedMeshes handed) = 0;

  // Whether it wants what the surfaces are of as well, with samples that are right away from them too; and what it gets
  // then, last, from a conversion that did not fail. The surfaces are the same.
  [[nodiscard]] virtual bool wants_source() const { return false; }
  virtual void take_source(Source&& /*source*/) {}
};

}  // namespace isoextract::convert
