// Gives the parts of a mesh that lie in windows: copied from the mesh, or extracted again.
#pragma once

#include <cstdint>

#include "accuracy/detail/search_window.hpp"
#include "accuracy/index_mesh.hpp"
#include "base/buffer.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "extract/extractor.hpp"

namespace isoextract::accuracy {

// Returns the box of samples outside which an isosurface without caps has no triangles.
[[nodiscard]] field::IndexBox surface_box(const field::ScalarField& field);

// Extracts the part of a surface in a window; without triangles if the window has no cell of the region in `options`.
// Fails as an extraction does.
[[nodiscard]] Result<mesh::Mesh> extract_within(const SearchWindow& window, const field::ScalarField& field,
                                                extract::ExtractOptions options, const Context& context);

class MeshParts {
 public:
  MeshParts() = default;
  MeshParts(const MeshParts&) = delete;
  MeshParts& operator=(const MeshParts&) = delete;
  virtual ~MeshParts() = default;

  // Returns a box of samples that the mesh does not leave; empty without vertices.
  [[nodiscard]] virtual field::IndexBox samples() const = 0;
  [[nodiscard]] virtual bool has_triangles() const = 0;
  // Returns a mesh of all triangles and vertices that reach into the window, in the order of the whole mesh. It is
  // valid until the next call. Fails with ErrorCode::out_of_memory. Throws std::bad_alloc.
  [[nodiscard]] virtual Result<const mesh::Mesh*> part(const SearchWindow& window) = 0;
};

// A mesh in memory.
class MeshInMemory final : public MeshParts {
 public:
  // `placed` is `mesh` in index space. Both must outlive the object.
  MeshInMemory(const mesh::Mesh& mesh, const IndexMesh& placed, const Context& context);

  [[nodiscard]] field::IndexBox samples() const override { return samples_; }
  [[nodiscard]] bool has_triangles() const override { return !mesh_.triangles.empty(); }
  [[nodiscard]] Result<const mesh::Mesh*> part(const SearchWindow& window) override;

 private:
  const mesh::Mesh& mesh_;
  const IndexMesh& placed_;
  const Context& context_;
  field::IndexBox samples_;
  Reservation numbers_memory_;
  Buffer<std::uint32_t> numbers_;  // of each vertex of the mesh: its number in the part
  mesh::Mesh part_;
};

// A mesh that an extraction makes. Parts have the positions of the whole mesh, because they share its origin.
class ExtractedMesh final : public MeshParts {
 public:
  // `extracted` must not ask for a cap, and the mesh must have triangles. All arguments must outlive the object.
  ExtractedMesh(const field::ScalarField& field, const extract::ExtractOptions& extracted, const Context& context);

  [[nodiscard]] field::IndexBox samples() const override { return surface_box(field_); }
  [[nodiscard]] bool has_triangles() const override { return true; }
  [[nodiscard]] Result<const mesh::Mesh*> part(const SearchWindow& window) override;

 private:
  const field::ScalarField& field_;
  const Context& context_;
  extract::ExtractOptions options_;
  mesh::Mesh part_;
};

}  // namespace isoextract::accuracy
