#include "mesh_io/detail/draco_codec.hpp"

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <fmt/format.h>

namespace isoextract::mesh_io {
namespace {

constexpr const char* kNameKey = "name";
constexpr const char* kGeneratorKey = "generator";
constexpr const char* kPlacementKey = "placement";
// Upper bounds of the library's memory while decoding. Per triangle and per vertex: its corner table and maps (kCodec).
// For each attribute connectivity, per triangle and per vertex (kSeam): seams may give each corner its own vertex. This
// needs two vertex maps that grow by doubling, two that do not, the corners' vertices and the list of seams.
// Per attribute value, besides its numbers: its entries in the map from points and in the decoding sequence
// (kValueMap).
constexpr std::uint64_t kCodecTriangleBytes = 96;
constexpr std::uint64_t kCodecVertexBytes = 96;
constexpr std::uint64_t kSeamTriangleBytes = 112;
constexpr std::uint64_t kSeamVertexBytes = 24;
constexpr std::uint64_t kValueMapBytes = 12;

std::optional<draco::DataType> draco_type(mesh::ComponentType type) {
  using Type = mesh::ComponentType;
  switch (type) {
    case Type::i8: return draco::DT_INT8;
    case Type::u8: return draco::DT_UINT8;
    case Type::i16: return draco::DT_INT16;
    case Type::u16: return draco::DT_UINT16;
    case Type::f32: return draco::DT_FLOAT32;
    default: return std::nullopt;
  }
}

std::optional<mesh::ComponentType> component_type(draco::DataType type) {
  using Type = mesh::ComponentType;
  switch (type) {
    case draco::DT_INT8: return Type::i8;
    case draco::DT_UINT8: return Type::u8;
    case draco::DT_INT16: return Type::i16;
    case draco::DT_UINT16: return Type::u16;
    case draco::DT_INT32: return Type::i32;
    case draco::DT_UINT32: return Type::u32;
    case draco::DT_FLOAT32: return Type::f32;
    case draco::DT_FLOAT64: return Type::f64;
    default: return std::nullopt;
  }
}

// Builds the library's mesh. Its points are the vertices or, with face normals, the triangle corners.
class DracoEncoding {
 public:
  explicit DracoEncoding(const DracoInput& input) : input_(input) {
    const std::size_t triangles = input.triangles.size();
    mesh_.set_num_points(static_cast<std::uint32_t>(input.face_normals ? 3 * triangles : input.positions.size()));
    mesh_.SetNumFaces(triangles);
    for (std::size_t t = 0; t < triangles; ++t) {
      draco::Mesh::Face face;
      for (std::uint32_t c = 0; c < 3; ++c) {
        face[c] = input.face_normals ? static_cast<std::uint32_t>(3 * t + c) : input.triangles[t][static_cast<int>(c)];
      }
      mesh_.SetFace(draco::FaceIndex(static_cast<std::uint32_t>(t)), face);
    }
    add_positions();
    add_normals();
    for (std::size_t a = 0; a < input.attributes.size(); ++a) add_attribute(*input.attributes[a], input.names[a]);
    if (!input.generator.empty()) metadata().AddEntryString(kGeneratorKey, input.generator);
    if (!input.placement.empty()) metadata().AddEntryString(kPlacementKey, input.placement);
  }

  Result<std::vector<std::byte>> encode(DracoMethod method) {
    draco::ExpertEncoder encoder(mesh_);
    draco::EncoderOptions options = draco::EncoderOptions::CreateDefaultOptions();
    options.SetAttributeOptions(kDracoPositions, quantization());
    encoder.Reset(options);
    constexpr int kSpeed = 3;
    encoder.SetSpeedOptions(kSpeed, kSpeed);
    encoder.SetEncodingMethod(method == DracoMethod::edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING
                                                                 : draco::MESH_SEQUENTIAL_ENCODING);
    if (!input_.normals.empty()) encoder.SetAttributeQuantization(kDracoPositions + 1, kDracoNormalBits);
    draco::EncoderBuffer buffer;
    const draco::Status status = encoder.EncodeToBuffer(&buffer);
    if (!status.ok()) return fail(ErrorCode::output, fmt::format("Draco: {}", status.error_msg_string()));
    std::vector<std::byte> bytes(buffer.size());
    if (!bytes.empty()) std::memcpy(bytes.data(), buffer.data(), buffer.size());
    return bytes;
  }

 private:
  // Sets the options of SetAttributeExplicitQuantization(), but with exact numbers. The library stores them as text,
  // and its setters write six decimals, which is too imprecise for a lattice or a small mesh.
  [[nodiscard]] draco::Options quantization() const {
    // The library divides the range by the number of steps, which gives the step again without rounding.
    const float range = static_cast<float>((std::uint32_t{1} << input_.bits) - 1) * input_.step;
    draco::Options options;
    options.SetInt("quantization_bits", input_.bits);
    options.SetString("quantization_origin", fmt::format("{} {} {}", input_.first.x, input_.first.y, input_.first.z));
    options.SetString("quantization_range", fmt::format("{}", range));
    return options;
  }

  draco::PointAttribute& add(draco::GeometryAttribute::Type type, std::size_t components, draco::DataType data,
                             bool normalized, std::size_t values) {
    auto attribute = std::make_unique<draco::PointAttribute>();
    attribute->Init(type, static_cast<std::int8_t>(components), data, normalized, values);
    const int id = mesh_.AddAttribute(std::move(attribute));
    return *mesh_.attribute(id);
  }

  // Maps corner points to the values of their vertices, if points are corners.
  void map_vertices(draco::PointAttribute& attribute) {
    if (!input_.face_normals) return;
    attribute.SetExplicitMapping(mesh_.num_points());
    for (std::size_t t = 0; t < input_.triangles.size(); ++t) {
      for (std::uint32_t c = 0; c < 3; ++c) {
        attribute.SetPointMapEntry(draco::PointIndex(static_cast<std::uint32_t>(3 * t + c)),
                                   draco::AttributeValueIndex(input_.triangles[t][static_cast<int>(c)]));
      }
    }
  }

  void add_positions() {
    draco::PointAttribute& attribute =
        add(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32, false, input_.positions.size());
    for (std::size_t v = 0; v < input_.positions.size(); ++v) {
      const glm::vec3 position = input_.first + glm::vec3(input_.positions[v]) * input_.step;
      attribute.SetAttributeValue(draco::AttributeValueIndex(static_cast<std::uint32_t>(v)), &position);
    }
    map_vertices(attribute);
  }

  void add_normals() {
    if (input_.normals.empty()) return;
    draco::PointAttribute& attribute =
        add(draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32, false, input_.normals.size());
    attribute.buffer()->Write(0, input_.normals.data(), input_.normals.size_bytes());
    if (!input_.face_normals) return;
    attribute.SetExplicitMapping(mesh_.num_points());
    for (std::uint32_t p = 0; p < mesh_.num_points(); ++p) {
      attribute.SetPointMapEntry(draco::PointIndex(p), draco::AttributeValueIndex(p / 3));
    }
  }

  void add_attribute(const mesh::Attribute& source, const std::string& name) {
    const auto type =
        source.role == mesh::AttributeRole::color ? draco::GeometryAttribute::COLOR : draco::GeometryAttribute::GENERIC;
    draco::PointAttribute& attribute = add(type, source.components, draco_type(source.type).value_or(draco::DT_INVALID),
                                           source.normalized, source.values.size() / source.stride());
    attribute.buffer()->Write(0, source.values.data(), source.values.size());
    map_vertices(attribute);
    if (!input_.names_in_file) return;
    auto named = std::make_unique<draco::AttributeMetadata>();
    named->AddEntryString(kNameKey, name);
    named->set_att_unique_id(attribute.unique_id());
    metadata().AddAttributeMetadata(std::move(named));
  }

  draco::GeometryMetadata& metadata() {
    if (mesh_.metadata() == nullptr) mesh_.AddMetadata(std::make_unique<draco::GeometryMetadata>());
    return *mesh_.metadata();
  }

  const DracoInput& input_;
  draco::Mesh mesh_;
};

// Stops the library before it allocates more than `take` allows: the bytes may announce any count.
template <class Decoder>
class BoundedDecoder final : public Decoder {
 public:
  explicit BoundedDecoder(const TakeMemory& take) : take_(take) {}

 protected:
  bool DecodeConnectivity() override {
    draco::DecoderBuffer ahead = *this->buffer();
    std::uint32_t first = 0;
    std::uint32_t second = 0;
    if (!draco::DecodeVarint(&first, &ahead) || !draco::DecodeVarint(&second, &ahead)) return false;
    // One method stores the vertex count first, the other the triangle count.
    const std::uint64_t most = std::max(first, second);
    std::uint64_t bytes = most * (kCodecTriangleBytes + kCodecVertexBytes);
    if constexpr (std::is_same_v<Decoder, draco::MeshEdgebreakerDecoder>) {
      std::uint8_t connectivities = 0;
      if (!ahead.Decode(&connectivities)) return false;
      bytes += connectivities * most * (kSeamTriangleBytes + kSeamVertexBytes);
    }
    take_(bytes);
    return Decoder::DecodeConnectivity();
  }

  bool DecodeAllAttributes() override {
    const draco::PointCloud& points = *this->point_cloud();
    for (int a = 0; a < points.num_attributes(); ++a) {
      const draco::PointAttribute& attribute = *points.attribute(a);
      // Two arrays of integers, and the decoded value.
      const std::uint64_t value = std::uint64_t{attribute.num_components()} *
                                  (2 * sizeof(std::int32_t) + draco::DataTypeLength(attribute.data_type()));
      take_(points.num_points() * (value + kValueMapBytes));
    }
    return Decoder::DecodeAllAttributes();
  }

 private:
  const TakeMemory& take_;
};

template <class Decoder>
draco::Status decode(draco::DecoderBuffer& buffer, const TakeMemory& take, draco::Mesh& mesh) {
  BoundedDecoder<Decoder> decoder(take);
  const draco::DecoderOptions options;
  return decoder.Decode(options, &buffer, &mesh);
}

Result<DracoAttribute> attribute_of(const draco::Mesh& mesh, int index, const TakeMemory& take) {
  const draco::PointAttribute& source = *mesh.attribute(index);
  const auto type = component_type(source.data_type());
  DracoAttribute attribute;
  attribute.id = source.unique_id();
  attribute.components = source.num_components();
  if (!type || attribute.components == 0) {
    return fail(ErrorCode::input, "Draco: expected numeric attributes, found an attribute of another type");
  }
  attribute.type = *type;
  attribute.normalized = source.normalized();
  attribute.is_position = source.attribute_type() == draco::GeometryAttribute::POSITION;
  attribute.is_normal = source.attribute_type() == draco::GeometryAttribute::NORMAL;
  attribute.is_color = source.attribute_type() == draco::GeometryAttribute::COLOR;
  if (const draco::AttributeMetadata* named = mesh.GetAttributeMetadataByAttributeId(index)) {
    named->GetEntryString(kNameKey, &attribute.name);
  }
  const std::size_t stride = attribute.components * mesh::component_size(*type);
  take(mesh.num_points() * stride);
  attribute.values.resize(mesh.num_points() * stride);
  for (std::uint32_t p = 0; p < mesh.num_points(); ++p) {
    const draco::AttributeValueIndex value = source.mapped_index(draco::PointIndex(p));
    if (value.value() >= source.size()) {
      return fail(ErrorCode::input, fmt::format("Draco: expected a value of an attribute at each of {} vertices, found "
                                                "none at vertex {}",
                                                mesh.num_points(), p));
    }
    std::memcpy(attribute.values.data() + p * stride, source.GetAddress(value), stride);
  }
  return attribute;
}

}  // namespace

const DracoAttribute* DracoSurface::find(std::uint64_t id) const {
  const auto found = std::ranges::find(attributes, id, &DracoAttribute::id);
  return found == attributes.end() ? nullptr : &*found;
}

DracoAttribute* DracoSurface::find(std::uint64_t id) {
  const auto found = std::ranges::find(attributes, id, &DracoAttribute::id);
  return found == attributes.end() ? nullptr : &*found;
}

Result<std::vector<std::byte>> encode_draco(const DracoInput& input, DracoMethod method) {
  return DracoEncoding(input).encode(method);
}

bool is_draco(std::span<const std::byte> bytes) {
  constexpr std::string_view kMark = "DRACO";
  return bytes.size() >= kMark.size() && std::memcmp(bytes.data(), kMark.data(), kMark.size()) == 0;
}

Result<DracoSurface> decode_draco(std::span<const std::byte> bytes, const TakeMemory& take) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::DecoderBuffer ahead = buffer;
  draco::DracoHeader header;
  if (const draco::Status status = draco::PointCloudDecoder::DecodeHeader(&ahead, &header); !status.ok()) {
    return fail(ErrorCode::input, "expected a Draco bit stream, found other data");
  }
  if (header.version_major != draco::kDracoMeshBitstreamVersionMajor ||
      header.version_minor != draco::kDracoMeshBitstreamVersionMinor) {
    return fail(
        ErrorCode::input,
        fmt::format("expected a Draco bit stream of version {}.{}, found {}.{}", draco::kDracoMeshBitstreamVersionMajor,
                    draco::kDracoMeshBitstreamVersionMinor, header.version_major, header.version_minor));
  }
  if (header.encoder_type != draco::TRIANGULAR_MESH) {
    return fail(ErrorCode::input, "expected triangles in a Draco bit stream, found a point cloud");
  }
  draco::Mesh mesh;
  const draco::Status status = header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING
                                   ? decode<draco::MeshEdgebreakerDecoder>(buffer, take, mesh)
                                   : decode<draco::MeshSequentialDecoder>(buffer, take, mesh);
  if (!status.ok()) {
    return fail(ErrorCode::input, fmt::format("the Draco bit stream is damaged: {}", status.error_msg_string()));
  }
  DracoSurface surface;
  surface.vertices = mesh.num_points();
  take(mesh.num_faces() * sizeof(glm::uvec3));
  surface.triangles.reserve(mesh.num_faces());
  for (std::uint32_t f = 0; f < mesh.num_faces(); ++f) {
    const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(f));
    const glm::uvec3 corners(face[0].value(), face[1].value(), face[2].value());
    if (std::max({corners.x, corners.y, corners.z}) >= surface.vertices) {
      return fail(ErrorCode::input,
                  fmt::format("the Draco bit stream is damaged: expected indices below {}, the number "
                              "of vertices, found an index out of range in triangle {}",
                              surface.vertices, f));
    }
    surface.triangles.push_back(corners);
  }
  for (int a = 0; a < mesh.num_attributes(); ++a) {
    auto attribute = TRY(attribute_of(mesh, a, take));
    surface.attributes.push_back(std::move(attribute));
  }
  if (mesh.GetMetadata() != nullptr) {
    mesh.GetMetadata()->GetEntryString(kGeneratorKey, &surface.generator);
    mesh.GetMetadata()->GetEntryString(kPlacementKey, &surface.placement);
  }
  return surface;
}

}  // namespace isoextract::mesh_io
