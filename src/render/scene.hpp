// What a picture shows: a volume, surfaces, lights.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <glm/glm.hpp>

#include "base/error.hpp"
#include "base/words.hpp"
#include "field/affine.hpp"
#include "field/scalar_field.hpp"
#include "mesh/mesh.hpp"
#include "render/transfer_function.hpp"

namespace isoextract::render {

// A field that takes and gives light (emission and absorption; no shading, no shadows).
//
// It fills box_of_volume() and nothing beyond: of dense samples the box of the sample centres, at least two a side; of
// sparse ones that of the active voxels, one voxel larger on every side. In there a point has the trilinear interpolant
// of the eight samples around it, their values by ScalarField::scale.
struct Volume {
  const field::ScalarField* field = nullptr;  // not null; outlives the drawing
  field::Affine index_to_world;               // regular; the field's own unless the picture wants it elsewhere
  TransferFunction transfer;
  double unit_length = 1;  // the unit of the transfer function's opacities, in the world; finite, above 0
};

// In index space. ErrorCode::input names the field where it has fewer than two samples along an axis, or no voxels.
[[nodiscard]] Result<field::Box> box_of_volume(const field::ScalarField& field);

enum class Shading { smooth, flat };
constexpr auto words_of(Shading /*type*/) {
  return std::array{Word{Shading::smooth, "smooth"}, Word{Shading::flat, "flat"}};
}

// Both sides are seen: a normal, interpolated or flat, that is on the other side of the triangle's plane than the eye
// is turned around.
//
// Coverage: a pixel has a fragment of a triangle where the ray through its centre meets it between near and far. On an
// edge that two triangles share exactly one of them has it, unless the ray only touches both. A GPU moves corners to
// 1/256 of a pixel first, so pixels whose centres are that near to an edge may differ between backends.
struct Surface {
  const mesh::Mesh* mesh = nullptr;   // not null; outlives the drawing; indices in range
  glm::dvec3 colour{0.8, 0.8, 0.8};   // linear light
  double opacity = 1;                 // above 0, at most 1
  Shading shading = Shading::smooth;  // smooth needs the mesh's normals, interpolated and made unit; else flat: those
                                      // of the triangles' own planes
  bool vertex_colours = false;        // those of the mesh, in place of `colour`; an alpha there multiplies `opacity`.
                                      // The mesh must have an attribute of role colour: u8 is sRGB, u16 and f32 are
                                      // linear light; alpha is linear always
};

// From infinitely far away.
struct Light {
  glm::dvec3 towards{0.0, 0.0, 1.0};  // the light; any length but 0
  bool with_camera = true;            // `towards` is in view space (x right, y up, z to the viewer); else in the world
  glm::dvec3 colour{1.0};             // linear, at least 0

  friend bool operator==(const Light&, const Light&) = default;
};

// Ambient, Lambert and specular terms (moving water as voxels, docs/papers.md); the specular one by the half vector
// (Blinn, "Models of light reflection for computer synthesized pictures", 1977). With unit vectors n (normal), l (to a
// light), v (to the eye) and h = normalize(l + v), a fragment of base colour b has
//   b * ambient + sum over lights of light colour * (b * diffuse * max(n.l, 0) + specular * s),
// s = max(n.h, 0)^shininess where n.l > 0, else 0.
struct ShadingModel {
  double ambient = 0.2;
  double diffuse = 0.7;
  double specular = 0.2;
  double shininess = 32;  // at least 1

  friend bool operator==(const ShadingModel&, const ShadingModel&) = default;
};

// All parts are lent.
struct Scene {
  static constexpr std::size_t kMaxLights = 8;

  const Volume* volume = nullptr;  // null: none
  std::vector<Surface> surfaces;
  std::vector<Light> lights{Light{{-0.4, 0.6, 0.7}}};
  ShadingModel shading;
  glm::dvec4 background{0.0};  // linear, straight alpha: behind everything; (0, 0, 0, 0) leaves the picture transparent
};

// Everything that can be seen, in the world. ErrorCode::input where that is nothing, or not finite.
[[nodiscard]] Result<field::Box> box_of(const Scene& scene);

// What renderers ask first: everything that the contracts above ask for. ErrorCode::usage, or ErrorCode::input where a
// field or a mesh does not have it.
[[nodiscard]] Result<void> check(const Scene& scene);

}  // namespace isoextract::render
