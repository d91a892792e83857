// The contents of a picture: a volume, surfaces, lights.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <glm/glm.hpp>

#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "field/affine.hpp"
#include "field/scalar_field.hpp"
#include "mesh/mesh.hpp"
#include "render/transfer_function.hpp"

namespace isoextract::render {

// A field drawn by emission and absorption of light, without shading and shadows. Light of hot parts comes from
// `emission`.
//
// The volume fills volume_box() only. For dense samples this is the box of the sample centers, at least two per axis.
// For sparse samples it is the box of the active voxels, enlarged by one voxel on every side. Inside, values are the
// trilinear interpolant of the eight surrounding samples, scaled by ScalarField::scale.
struct Volume {
  const field::ScalarField* field = nullptr;  // not null; outlives the drawing
  field::Affine index_to_world;               // invertible; usually the field's own transform
  TransferFunction transfer;
  double unit_length = 1;  // world length to which the transfer function's opacities refer; finite, above 0
  // A second field, with its own placement, in which the volume emits light of its own; may be null, outlives the
  // drawing. Its transfer function, as emission_function() makes it, gives the light that each unit_length of a ray
  // gains, and as the fourth number the largest of the three colors. Its own unit_length and emission have no effect.
  // Light is emitted in all of the emission's volume_box(), also outside of that of `field`.
  const Volume* emission = nullptr;
};

// Returns the box of a volume's field in index space. Fails with ErrorCode::input if a dense field has fewer than two
// samples along an axis, and with ErrorCode::empty_grid if a sparse field has no active voxels.
[[nodiscard]] Result<field::Box> volume_box(const field::ScalarField& field);

enum class Shading { smooth, flat };
constexpr auto words_of(Shading /*type*/) {
  return std::array{Word{Shading::smooth, "smooth"}, Word{Shading::flat, "flat"}};
}

// A triangle mesh to draw. Both sides are visible: a normal that points away from the eye's side of the triangle's
// plane is flipped for shading.
//
// Coverage: a pixel has a fragment of a triangle if the ray through its center hits the triangle between the near and
// far depths of the camera. On an edge shared by two triangles exactly one of them has the fragment, unless the edge is
// part of a silhouette: there both triangles lie on the same side of it in the picture. A GPU first rounds corners to
// 1/256 of a pixel, so backends may differ at pixels whose centers are that close to an edge.
struct Surface {
  const mesh::Mesh* mesh = nullptr;  // not null; outlives the drawing; indices in range
  glm::dvec3 color{0.8, 0.8, 0.8};   // linear light
  double opacity = 1;                // in (0, 1]
  // Smooth interpolates the mesh's normals and normalizes them; flat uses the triangles' planes, and so does smooth if
  // the mesh has no normals.
  Shading shading = Shading::smooth;
  // Uses the mesh's vertex colors instead of `color`; their alpha multiplies `opacity`. The mesh must have an
  // attribute with AttributeRole::color and at least three components: u8 is sRGB, u16 and f32 are linear light; alpha
  // is always linear.
  bool vertex_colors = false;
};

// Returns the linear color and alpha of a vertex, converted as Surface::vertex_colors says.
[[nodiscard]] glm::dvec4 vertex_color(const mesh::Attribute& attribute, std::size_t vertex);

// A directional light.
struct Light {
  glm::dvec3 towards{0.0, 0.0, 1.0};  // direction to the light; of any length except 0
  bool moves_with_camera = true;  // `towards` is in view space (x right, y up, z to the viewer); otherwise in the world
  glm::dvec3 color{1.0};          // linear, at least 0

  friend bool operator==(const Light&, const Light&) = default;
};

// Ambient, Lambert and specular terms (moving water as voxels, docs/papers.md); the specular term uses the half vector
// (Blinn, "Models of light reflection for computer synthesized pictures", 1977). The unit vectors are n (normal), l (to
// a light), v (to the eye) and h = normalize(l + v). A fragment of base color b has the color
//   b * ambient + sum over lights of light color * (b * diffuse * max(n.l, 0) + specular * s),
// where s = max(n.h, 0)^shininess if n.l > 0, else 0.
struct ShadingModel {
  double ambient = 0.2;
  double diffuse = 0.7;
  double specular = 0.2;
  double shininess = 32;  // at least 1

  friend bool operator==(const ShadingModel&, const ShadingModel&) = default;
};

// Does not own the volume and the meshes.
struct Scene {
  static constexpr std::size_t kMaxLights = 8;

  const Volume* volume = nullptr;  // may be null
  std::vector<Surface> surfaces;
  std::vector<Light> lights{Light{{-0.4, 0.6, 0.7}}};
  ShadingModel shading;
  glm::dvec4 background{0.0};  // linear, straight alpha; (0, 0, 0, 0) keeps the picture transparent
};

// Returns the box around the volume and all vertices, in the world. Fails with ErrorCode::input if it is empty or not
// finite, and as volume_box() does.
[[nodiscard]] Result<field::Box> box_of(const Scene& scene);

// Checks the requirements stated above, except pointers and vertex indices. Fails with ErrorCode::input if a field, its
// transform or a mesh does not meet them, with ErrorCode::usage if another part does not, and as volume_box() does.
[[nodiscard]] Result<void> check(const Scene& scene);

}  // namespace isoextract::render
