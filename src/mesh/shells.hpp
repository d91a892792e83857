// Finds which closed shells of a mesh lie inside which. Checks, component filters and simplification share this code.
//
// All rays have one direction. The ray of a shell starts at its vertex that is farthest in this direction. The shell
// lies inside every other shell that its ray crosses an odd number of times. The test is exact: a ray through an edge
// or a corner is treated as if it were shifted a little, in the same way for all triangles. If the vertex lies on
// another shell, the ray starts beside the middle of a triangle at the vertex instead, on its material's side.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/components.hpp"
#include "mesh/mesh.hpp"
#include "mesh/partwise_components.hpp"

namespace isoextract::mesh {

// The kind of a component: open, or the side that its triangles face.
enum class Facing : std::uint8_t { open, outward, inward };

struct Surroundings {
  // The other closed components that this one lies inside, ascending.
  std::vector<std::uint32_t> around;
  // For a component that faces inward and lies inside no closed component: the first open component that its ray meets.
  std::uint32_t open = Components::kNone;

  // Returns whether the component lies in material: inside an odd number of closed shells, if all are oriented
  // correctly.
  [[nodiscard]] bool in_material() const { return around.size() % 2 == 1; }
};

struct ShellQuery {
  std::vector<Facing> facing{};  // of each component
  bool test_outward = true;      // whether to test outward shells, too; inward shells are always tested
  bool find_open = false;        // whether to find `Surroundings::open`
};

// Returns the surroundings of each component in order; empty for components that are open or not tested. Of two shells
// side by side with a common wall, neither lies inside the other. If shells intersect, the result may say that one lies
// inside the other, or not. The result is the same for any number of threads. Fails with ErrorCode::out_of_memory and
// ErrorCode::cancelled; throws std::bad_alloc.
[[nodiscard]] Result<std::vector<Surroundings>> find_enclosing_shells(const Mesh& mesh, const Components& components,
                                                                      const ShellQuery& question,
                                                                      const Context& context);

// Does the same for a mesh that comes in parts. look_at() gets each part first; then each step gets each part, in
// order.
class PartwiseShells {
 public:
  enum class Step { shoot, move_starts, done };

  // `name` is the name of the mesh, for messages.
  PartwiseShells(const std::string& name, const Context& context);
  ~PartwiseShells();

  // Makes memory for the components. Fails with ErrorCode::out_of_memory.
  [[nodiscard]] Result<void> begin(std::uint32_t components);
  void look_at(const LocalPart& part);
  // Returns mesh::float32_resolution() of all positions.
  [[nodiscard]] double resolution() const;

  // Starts the steps. Returns the first one, as end_step() returns the next: take() gets each part for it. Step::done:
  // the surroundings are found. Fails with ErrorCode::out_of_memory.
  [[nodiscard]] Result<Step> begin_steps(ShellQuery question);
  [[nodiscard]] Step end_step();
  void take(const LocalPart& part);

  // Returns the surroundings. Call once, after Step::done. Fails with ErrorCode::cancelled.
  [[nodiscard]] Result<std::vector<Surroundings>> finish();

 private:
  class Rays;
  std::unique_ptr<Rays> rays_;
};

}  // namespace isoextract::mesh
