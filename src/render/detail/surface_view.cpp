#include "render/detail/surface_view.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/srgb.hpp"

namespace isoextract::render::detail {
namespace {

template <class V>
V blend(const glm::dvec3& weights, const V& a, const V& b, const V& c) {
  return weights.x * a + weights.y * b + weights.z * c;
}

}  // namespace

SurfaceView::SurfaceView(const Scene& scene, const Camera& camera, const PictureSize& size)
    : scene_(scene), rotation_(camera.rotation()), first_{0} {
  const glm::dvec3 corner = direction_through(camera, size, 0, 0);
  const glm::dvec3 opposite = direction_through(camera, size, size.width, size.height);
  to_left_ = corner.x;
  to_top_ = corner.y;
  per_pixel_ = {(opposite.x - corner.x) / size.width, (corner.y - opposite.y) / size.height};
  const field::Affine view = camera.view_from_world();
  for (const Surface& surface : scene.surfaces) {
    const mesh::Mesh& mesh = *surface.mesh;
    first_.push_back(first_.back() + mesh.triangles.size());
    Look look;
    look.view = {view.linear, view(mesh.origin)};
    look.smooth = surface.shading == Shading::smooth && !mesh.normals.empty();
    if (surface.vertex_colors) {
      look.colors = &*std::ranges::find_if(mesh.attributes, [](const mesh::Attribute& attribute) {
        return attribute.role == mesh::AttributeRole::color;
      });
    }
    look.is_opaque = surface.opacity == 1 && (look.colors == nullptr || look.colors->components < 4);
    looks_.push_back(look);
  }
  for (const Light& light : scene.lights) {
    towards_.push_back(glm::normalize(light.moves_with_camera ? light.towards : rotation_ * light.towards));
  }
}

std::size_t SurfaceView::surface_of(std::uint64_t triangle) const {
  return static_cast<std::size_t>(std::ranges::upper_bound(first_, triangle) - first_.begin()) - 1;
}

Corners SurfaceView::corners(std::size_t surface, std::uint64_t triangle) const {
  const mesh::Mesh& mesh = *scene_.surfaces[surface].mesh;
  const glm::uvec3& t = mesh.triangles[triangle - first_[surface]];
  const field::Affine& view = looks_[surface].view;
  return {view(glm::dvec3(mesh.positions[t.x])), view(glm::dvec3(mesh.positions[t.y])),
          view(glm::dvec3(mesh.positions[t.z]))};
}

Shade SurfaceView::shade(std::uint64_t triangle, const glm::dvec3& direction) const {
  const std::size_t number = surface_of(triangle);
  const Surface& surface = scene_.surfaces[number];
  const Look& look = looks_[number];
  const mesh::Mesh& mesh = *surface.mesh;
  const glm::uvec3& t = mesh.triangles[triangle - first_[number]];
  const auto [p0, p1, p2] = corners(number, triangle);

  // Barycentric weights of the point where the ray hits the plane.
  glm::dvec3 weights(glm::dot(glm::cross(p1, p2), direction), glm::dot(glm::cross(p2, p0), direction),
                     glm::dot(glm::cross(p0, p1), direction));
  weights /= weights.x + weights.y + weights.z;

  const glm::dvec3 to_eye = -glm::normalize(direction);
  glm::dvec3 plane = glm::normalize(glm::cross(p1 - p0, p2 - p0));
  if (glm::dot(plane, to_eye) < 0) plane = -plane;
  glm::dvec3 normal = plane;
  if (look.smooth) {
    const glm::dvec3 between = rotation_ * blend(weights, glm::dvec3(mesh.normals[t.x]), glm::dvec3(mesh.normals[t.y]),
                                                 glm::dvec3(mesh.normals[t.z]));
    const double length = glm::length(between);
    if (length > 0 && std::isfinite(length)) normal = between / length;
    if (glm::dot(normal, plane) < 0) normal = -normal;
  }

  glm::dvec4 base(surface.color, 1);
  if (look.colors != nullptr) {
    base = blend(weights, vertex_color(*look.colors, t.x), vertex_color(*look.colors, t.y),
                 vertex_color(*look.colors, t.z));
  }
  const ShadingModel& shading = scene_.shading;
  glm::dvec3 light = glm::dvec3(base) * shading.ambient;
  for (std::size_t l = 0; l < towards_.size(); ++l) {
    const double lambert = glm::dot(normal, towards_[l]);
    if (!(lambert > 0)) continue;
    const glm::dvec3 half = towards_[l] + to_eye;
    const double half_length = glm::length(half);
    const double gloss = half_length > 0 ? std::max(glm::dot(normal, half) / half_length, 0.0) : 0;
    light += scene_.lights[l].color *
             (glm::dvec3(base) * (shading.diffuse * lambert) + shading.specular * std::pow(gloss, shading.shininess));
  }
  return {glm::vec3(light), static_cast<float>(std::clamp(surface.opacity * base.a, 0.0, 1.0)),
          glm::vec3(glm::transpose(rotation_) * normal)};
}

}  // namespace isoextract::render::detail
