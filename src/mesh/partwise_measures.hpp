// Measures a mesh while it is made part by part, with the result of measure_mesh(). The mesh is made twice for it: the
// first pass finds which components of the parts belong together, the second one sums for each component. At a time,
// only two parts are in memory, the vertices to which a cap refers, and some bytes for each component. If ranks share
// the mesh, each measures its parts, and all get the same result, that of one process.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/ranks.hpp"
#include "mesh/mesh_measures.hpp"
#include "mesh/mesh_sink.hpp"
#include "mesh/partwise_components.hpp"

namespace isoextract::mesh {

class PartwiseMeasures final : public MeshSink {
 public:
  // Gets each part in the second pass, after it was measured.
  using LookAtPart = std::function<Result<void>(const LocalPart& part)>;

  // `name` is the name of the mesh, for messages. Areas and volumes of components are in the space that `to_metric`
  // maps to; those of the whole mesh are not.
  PartwiseMeasures(const std::string& name, const Context& context, const glm::dmat3& to_metric = glm::dmat3(1.0),
                   LookAtPart look_at = {});
  // The mesh must have no cap. `ranks` may be null; ignored if they do not share the task at begin().
  PartwiseMeasures(const std::string& name, const Context& context, Ranks* ranks);
  ~PartwiseMeasures() override;

  [[nodiscard]] Ranks* ranks() const override;
  Result<bool> begin(const MeshShape& shape) override;
  [[nodiscard]] std::vector<PartPass> passes() const override;
  // All functions may fail with ErrorCode::out_of_memory. take() in the second pass, and finish(), also fail with
  // ErrorCode::input if the mesh of this pass differs from that of the first pass. With ranks, all fail as
  // Ranks::gather() does, too.
  [[nodiscard]] Result<void> begin_pass(std::size_t pass) override;
  Result<void> take(const MeshPart& part) override;
  // Call once, after the last part.
  [[nodiscard]] Result<MeshMeasures> finish();
  // Returns the components, for passes after finish().
  [[nodiscard]] PartwiseComponents& components();

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace isoextract::mesh
