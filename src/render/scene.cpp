#include "render/scene.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <variant>

#include <fmt/format.h>

#include "base/finite.hpp"
#include "base/srgb.hpp"
#include "mesh/metrics.hpp"
#include "render/renderer.hpp"

namespace isoextract::render {
namespace {

Result<void> refuse(const std::string& what) { return fail(ErrorCode::usage, "the scene: " + what); }

bool is_light(const glm::dvec3& color) { return is_finite(color) && color.r >= 0 && color.g >= 0 && color.b >= 0; }

Result<void> check_placed(const Volume& volume) {
  TRY(volume_box(*volume.field));
  if (volume.index_to_world.is_invertible()) return {};
  return fail(ErrorCode::input, fmt::format("{}: its transform from indices to coordinates is singular or not finite",
                                            volume.field->source));
}

Result<void> check_volume(const Volume& volume) {
  TRY(check_placed(volume));
  if (volume.emission != nullptr) TRY(check_placed(*volume.emission));
  if (!(volume.unit_length > 0) || !std::isfinite(volume.unit_length)) {
    return refuse(fmt::format("the opacity unit length of the volume must be above 0, found {:g}", volume.unit_length));
  }
  return {};
}

Result<void> check_surface(const Surface& surface) {
  const mesh::Mesh& mesh = *surface.mesh;
  if (!is_light(surface.color)) return refuse("the color of a surface must be finite and at least 0");
  if (!(surface.opacity > 0 && surface.opacity <= 1)) {
    return refuse(fmt::format("the opacity of a surface must be above 0 and at most 1, found {:g}", surface.opacity));
  }
  if (!mesh.normals.empty() && mesh.normals.size() != mesh.positions.size()) {
    return fail(ErrorCode::input, fmt::format("{}: expected a normal for each of {} vertices, found {}", mesh.name,
                                              mesh.positions.size(), mesh.normals.size()));
  }
  if (surface.vertex_colors && std::ranges::none_of(mesh.attributes, [](const mesh::Attribute& attribute) {
        using mesh::ComponentType;
        return attribute.role == mesh::AttributeRole::color && attribute.components >= 3 &&
               (attribute.type == ComponentType::u8 || attribute.type == ComponentType::u16 ||
                attribute.type == ComponentType::f32);
      })) {
    return fail(
        ErrorCode::input,
        fmt::format("{}: expected vertex colors of at least three components, of type u8, u16 or f32; found none",
                    mesh.name));
  }
  return {};
}

template <class T>
T component(const mesh::Attribute& attribute, std::size_t vertex, std::size_t c) {
  T value;
  std::memcpy(&value, attribute.at(vertex).data() + c * sizeof(T), sizeof value);
  return value;
}

}  // namespace

glm::dvec4 vertex_color(const mesh::Attribute& attribute, std::size_t vertex) {
  glm::dvec4 color(0, 0, 0, 1);
  for (std::size_t c = 0; c < attribute.components; ++c) {
    double& channel = color[static_cast<int>(c)];
    switch (attribute.type) {
      case mesh::ComponentType::u8: {
        const double encoded = component<std::uint8_t>(attribute, vertex, c) / 255.0;
        channel = c < 3 ? srgb_to_linear(encoded) : encoded;
        break;
      }
      case mesh::ComponentType::u16: channel = component<std::uint16_t>(attribute, vertex, c) / 65535.0; break;
      default: channel = double{component<float>(attribute, vertex, c)};
    }
  }
  return color;
}

Result<field::Box> volume_box(const field::ScalarField& field) {
  if (const auto* dense = std::get_if<field::DenseSamples>(&field.samples)) {
    if (dense->dims.x < 2 || dense->dims.y < 2 || dense->dims.z < 2) {
      return fail(ErrorCode::input, fmt::format("{}: expected at least two samples along each axis, found {} x {} x {}",
                                                field.source, dense->dims.x, dense->dims.y, dense->dims.z));
    }
    return field::Box{glm::dvec3(0), glm::dvec3(dense->dims - 1)};
  }
  const field::IndexBox active = field.extents();
  if (active.empty()) {
    return fail(ErrorCode::empty_grid, fmt::format("{}: the grid has no active voxels", field.source));
  }
  return field::Box{glm::dvec3(active.min) - 1.0, glm::dvec3(active.max) + 1.0};
}

Result<field::Box> box_of(const Scene& scene) {
  field::Box box{glm::dvec3(std::numeric_limits<double>::infinity()),
                 glm::dvec3(-std::numeric_limits<double>::infinity())};
  const auto add = [&](const field::Box& part) {
    box.min = glm::min(box.min, part.min);
    box.max = glm::max(box.max, part.max);
  };
  for (const Volume* volume : {scene.volume, scene.volume != nullptr ? scene.volume->emission : nullptr}) {
    if (volume == nullptr) continue;
    const auto indices = TRY(volume_box(*volume->field));
    add(field::image_of(volume->index_to_world, indices));
  }
  for (const Surface& surface : scene.surfaces) {
    if (surface.mesh->positions.empty()) continue;
    const mesh::Bounds bounds = mesh::measure_bounds(*surface.mesh);
    add({bounds.min, bounds.max});
  }
  if (!(box.min.x <= box.max.x)) return fail(ErrorCode::input, "the scene is empty: it has no volume and no triangles");
  if (!is_finite(box.min) || !is_finite(box.max)) {
    return fail(ErrorCode::input, "the bounding box of the scene is not finite");
  }
  return box;
}

Result<void> check(const Scene& scene) {
  if (scene.volume != nullptr) {
    TRY(check_volume(*scene.volume));
  }
  for (const Surface& surface : scene.surfaces) {
    TRY(check_surface(surface));
  }
  if (scene.lights.size() > Scene::kMaxLights) {
    return refuse(fmt::format("expected at most {} lights, found {}", Scene::kMaxLights, scene.lights.size()));
  }
  for (const Light& light : scene.lights) {
    const double length = glm::length(light.towards);
    if (!is_light(light.color) || !(length > 0) || !std::isfinite(length)) {
      return refuse("a light must have a finite direction that is not zero, and a finite color of at least 0");
    }
  }
  const ShadingModel& shading = scene.shading;
  const auto share = [](double v) { return v >= 0 && std::isfinite(v); };
  if (!share(shading.ambient) || !share(shading.diffuse) || !share(shading.specular) || !(shading.shininess >= 1) ||
      !std::isfinite(shading.shininess)) {
    return refuse(
        "the ambient, diffuse and specular terms must be finite and at least 0, and the shininess at least 1");
  }
  if (!is_light(glm::dvec3(scene.background)) || !(scene.background.a >= 0 && scene.background.a <= 1)) {
    return refuse("the background color must be finite and at least 0, and its alpha from 0 to 1");
  }
  return {};
}

double step_of(const Volume& volume, const RenderOptions& options) {
  const auto shortest_edge = [](const glm::dmat3& axes) {
    return std::min({glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2])});
  };
  double edge = shortest_edge(volume.index_to_world.linear);
  if (volume.emission != nullptr) edge = std::min(edge, shortest_edge(volume.emission->index_to_world.linear));
  return edge / options.samples_per_voxel;
}

Result<void> check(const Scene& scene, const Camera& camera, const RenderOptions& options) {
  const auto side = [](int pixels) { return pixels >= 1 && pixels <= PictureSize::kMaxSide; };
  if (!side(options.size.width) || !side(options.size.height)) {
    return fail(ErrorCode::usage, fmt::format("expected a picture of 1 to {} pixels per side, found {} x {}",
                                              PictureSize::kMaxSide, options.size.width, options.size.height));
  }
  if (!(options.samples_per_voxel >= 1.0 / 64 && options.samples_per_voxel <= 64)) {
    return fail(ErrorCode::usage,
                fmt::format("expected 1/64 to 64 samples per voxel, found {:g}", options.samples_per_voxel));
  }
  if (!(options.termination > 0 && options.termination < 1)) {
    return fail(
        ErrorCode::usage,
        fmt::format("the transmittance that ends a ray must be above 0 and below 1, found {:g}", options.termination));
  }
  TRY(camera.check());
  return check(scene);
}

}  // namespace isoextract::render
