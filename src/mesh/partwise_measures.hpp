// Measures a mesh while it is made part by part, with the result of measure_mesh(). The mesh is made twice for it: the
// first pass finds which components of the parts belong together, the second one sums for each component. At a time,
// only two parts are in memory, the vertices to which a cap refers, and some bytes for each component.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh_measures.hpp"
#include "mesh/mesh_sink.hpp"

namespace isoextract::mesh {

class PartwiseMeasures final : public MeshSink {
 public:
  // `name` is the name of the mesh, for messages.
  PartwiseMeasures(const std::string& name, const Context& context);
  ~PartwiseMeasures() override;

  Result<bool> begin(const MeshShape& shape) override;
  [[nodiscard]] std::vector<PartPass> passes() const override;
  // All functions may fail with ErrorCode::out_of_memory. take() in the second pass, and finish(), also fail with
  // ErrorCode::input if the mesh of this pass differs from that of the first pass.
  [[nodiscard]] Result<void> begin_pass(std::size_t pass) override;
  Result<void> take(const MeshPart& part) override;
  // Call once, after the last part.
  [[nodiscard]] Result<MeshMeasures> finish();

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace isoextract::mesh
