// glTF 2.0 (ISO/IEC 12113): TinyGLTF builds the model and its JSON (gltf_model); the binary data goes from the meshes'
// buffers directly to the file. Each mesh is laid out before it is written, so that the JSON knows every offset. In a
// GLB, whose JSON precedes the data, all meshes are laid out first. If its one mesh comes in parts, room for the JSON
// is left before the data; in a stream, a pass over the parts finds the bounds for the JSON. If the meshes of a GLB
// exceed most_held_bytes() together, their data is written first, and moves when the JSON is known.
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/packed_values.hpp"
#include "files/record_stream.hpp"
#include "mesh_io/write/first_array.hpp"
#include "mesh_io/write/glb_container.hpp"
#include "mesh_io/write/gltf_model.hpp"
#include "mesh_io/write/gltf_packed_part.hpp"
#include "mesh_io/write/gltf_part.hpp"
#include "mesh_io/write/mesh_format_writers.hpp"
#include "mesh_io/write/partwise_writer.hpp"

namespace isoextract::mesh_io {
namespace {

// Returns an error if a GLB cannot have this size.
Result<void> check_glb_length(std::uint64_t json_bytes, std::uint64_t binary_bytes, const files::OutputFile& file) {
  const std::uint64_t length = glb_bytes(json_bytes, binary_bytes);
  if (length <= std::numeric_limits<std::uint32_t>::max()) return {};
  return fail(ErrorCode::output,
              fmt::format("{}: a .glb holds less than 4 GiB; this one needs {} bytes", file.shown_name(), length),
              {Remedy::set, Setting::mesh_format, "gltf or ply"});
}

// Returns whether a file's JSON gets a fixed length, whatever the bounds of its positions, so that it can be written
// after the data: the file has one large mesh.
bool reserves_bounds(const GltfPart& part) {
  return part.packed == nullptr && part.layout == GltfPart::Layout::indexed && !part.short_indices;
}

// Returns the greatest length of the JSON of a file with this part, whatever its bounds are.
std::size_t longest_json(GltfPart part, const std::string& placement) {
  constexpr float kLongest = -std::numeric_limits<float>::min();  // -1.1754943508222875e-38
  part.bounds = mesh::LocalBounds{glm::vec3(kLongest), glm::vec3(kLongest)};
  GltfModel model(placement);
  model.add(part);
  Notes of_another;
  return gltf_aligned(model.json({}, -1, of_another).size());
}

class GlbWriter final : public FormatWriter {
 public:
  GlbWriter(const MeshWriteOptions& options, const Context& context, files::OutputFile& file)
      : options_(options), context_(context), file_(file) {}

  Result<void> add(const mesh::Mesh& mesh, Notes& notes) override {
    auto part = TRY(GltfPart::make(mesh, options_, context_, notes));
    parts_.push_back(std::move(part));
    binary_bytes_ += parts_.back().bytes();
    // Measures no bounds for a file that is too large.
    if (check_glb_length(0, binary_bytes_, file_)) model_.add(parts_.back());
    return {};
  }

  Result<void> finish(Notes& notes) override {
    TRY(check_glb_length(0, binary_bytes_, file_));
    std::string text = model_.json({}, -1, notes);
    pad_glb_json(text);
    if (parts_.size() == 1 && reserves_bounds(parts_.front())) {
      text.resize(longest_json(parts_.front(), options_.placement), ' ');
    }
    TRY(check_glb_length(text.size(), binary_bytes_, file_));
    auto written = file_.write(glb_start(text.size(), binary_bytes_));
    if (written) written = file_.write(text);
    if (!written || binary_bytes_ == 0) return written;
    written = file_.write(glb_binary_head(binary_bytes_));
    for (std::size_t p = 0; p < parts_.size() && written; ++p) written = write_part(parts_[p], file_);
    return written;
  }

  [[nodiscard]] std::vector<PackedFacts> packed() const override {
    std::vector<PackedFacts> facts;
    for (const GltfPart& part : parts_) facts.push_back(part.packed != nullptr ? part.packed->facts : PackedFacts{});
    return facts;
  }

 private:
  MeshWriteOptions options_;
  Context context_;
  files::OutputFile& file_;
  std::vector<GltfPart> parts_;
  GltfModel model_{options_.placement};
  std::uint64_t binary_bytes_ = 0;
};

class MovingGlbWriter final : public FormatWriter {
 public:
  MovingGlbWriter(const MeshWriteOptions& options, const Context& context, files::OutputFile& file)
      : options_(options), context_(context), file_(file) {}

  Result<void> add(const mesh::Mesh& mesh, Notes& notes) override {
    const auto part = TRY(GltfPart::make(mesh, options_, context_, notes));
    model_.add(part);
    binary_bytes_ += part.bytes();
    return write_part(part, file_);
  }

  Result<void> finish(Notes& notes) override {
    std::string text = model_.json({}, -1, notes);
    pad_glb_json(text);
    TRY(check_glb_length(text.size(), binary_bytes_, file_));
    std::string head = glb_start(text.size(), binary_bytes_) + text;
    if (binary_bytes_ == 0) return file_.write(head);
    head += glb_binary_head(binary_bytes_);
    TRY(file_.move_end(0, head.size()));
    return file_.overwrite(0, std::as_bytes(std::span(std::as_const(head))));
  }

 private:
  MeshWriteOptions options_;
  Context context_;
  files::OutputFile& file_;
  GltfModel model_{options_.placement};
  std::uint64_t binary_bytes_ = 0;
};

// Returns the reference to a file beside the model (RFC 3986, 2.3).
std::string uri_of(const std::string& name) {
  std::string uri;
  for (const char c : name) {
    const bool unreserved = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                            std::string_view("-._~").find(c) != std::string_view::npos;
    uri += unreserved ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return uri;
}

constexpr int kGltfIndent = 2;

// The JSON of a file whose one mesh comes in parts. It has the bounds of the positions, which are known last.
class PartwiseJson {
 public:
  PartwiseJson(const mesh::Mesh& head, const MeshWriteOptions& options) : head_(head), placement_(options.placement) {}

  // Returns false if the length of the JSON of a GLB depends on the bounds.
  bool begin(const mesh::MeshShape& shape) {
    const GltfPart part(head_, shape, notes_);
    if (!reserves_bounds(part)) return false;
    part_.emplace(part);
    return true;
  }

  [[nodiscard]] const GltfPart& layout() const { return *part_; }
  [[nodiscard]] bool has_attributes() const { return !part_->semantics.empty(); }

  // Returns whether begin() would return true for a mesh of this shape.
  [[nodiscard]] bool has_places(const mesh::MeshShape& shape) const {
    Notes notes;  // begin() adds them
    return reserves_bounds(GltfPart(head_, shape, notes));
  }

  // Returns the JSON's length for a mesh of this shape in a GLB; nothing if it depends on the bounds or the mesh is too
  // large.
  [[nodiscard]] std::optional<std::size_t> glb_bytes_of(const mesh::MeshShape& shape) const {
    Notes notes;  // begin() adds them
    const GltfPart part(head_, shape, notes);
    const std::size_t bytes = longest_json(part, placement_);
    const bool fits = mesh_io::glb_bytes(bytes, part.bytes()) <= std::numeric_limits<std::uint32_t>::max();
    return has_places(shape) && fits ? std::optional(bytes) : std::nullopt;
  }

  // Returns the bytes of the JSON of a GLB. Fails if the file would be too large.
  [[nodiscard]] Result<std::size_t> glb_bytes(const files::OutputFile& file) const {
    const std::size_t bytes = longest_json(*part_, placement_);
    TRY(check_glb_length(bytes, part_->bytes(), file));
    return bytes;
  }
  [[nodiscard]] std::uint64_t binary_bytes() const { return part_->bytes(); }

  // Several threads may call it at once.
  void measure(const mesh::MeshPart& part) {
    mesh::GrowingBounds bounds;
    bounds.add(part.positions);
    const std::lock_guard lock(mutex_);
    bounds_.emplace(part.first_vertex, bounds);
  }

  [[nodiscard]] std::string facts() const {
    if (bounds_.empty()) return {};
    return Packer().put(bounds_.begin()->first).put(all_bounds()).take();
  }

  void add_facts(std::string_view facts) {
    if (facts.empty()) return;
    Unpacker from(facts);
    const auto first = from.get<std::uint64_t>();
    bounds_.emplace(first, from.get<mesh::GrowingBounds>());
  }

  [[nodiscard]] std::string text(const std::string& uri, int indent, Notes& notes) {
    notes.insert(notes.end(), notes_.begin(), notes_.end());
    part_->bounds = all_bounds().get();
    GltfModel model(placement_);
    model.add(*part_);
    return model.json(uri, indent, notes);
  }
  [[nodiscard]] std::string glb_text(std::size_t bytes, Notes& notes) {
    std::string text = this->text({}, -1, notes);
    text.resize(bytes, ' ');
    return text;
  }

 private:
  [[nodiscard]] mesh::GrowingBounds all_bounds() const {
    mesh::GrowingBounds all;
    for (const auto& [vertex, bounds] : bounds_) all.add(bounds);
    return all;
  }

  const mesh::Mesh& head_;
  std::string placement_;
  Notes notes_;  // notes about the attributes
  std::optional<GltfPart> part_;
  std::mutex mutex_;
  std::multimap<std::uint64_t, mesh::GrowingBounds> bounds_;  // by the first vertex of their part
};

// Returns the values of a part for an attribute, by its index in the mesh, padded as in the file. The part must outlive
// the result.
files::FillRecords padded_values_of(const mesh::MeshPart& part, std::size_t attribute) {
  return [&part, attribute](std::size_t first, std::size_t last, char* out) {
    for (std::size_t v = first; v < last; ++v) out = put_gltf_value(out, part.attributes[attribute], v);
    return out;
  };
}

std::size_t count_values(const mesh::MeshPart& part, std::size_t attribute) {
  const mesh::Attribute& values = part.attributes[attribute];
  return values.values.size() / values.stride();
}

// Returns the index of an attribute in the mesh.
std::size_t attribute_index_of(const GltfSemantic& semantic, const GltfPart& layout) {
  return static_cast<std::size_t>(semantic.attribute - layout.mesh->attributes.data());
}

// File offsets of the arrays of one mesh.
class PartPlaces {
 public:
  // Positions can be filled in from file offset `at` on, a guess. begin() follows.
  void begin_early(std::uint64_t at) { positions_.begin_early(at); }

  // Writes the start of the file, and makes room for the arrays behind it.
  Result<void> begin(files::OutputFile& file, const std::string& start, const GltfPart& layout) {
    const mesh::MeshShape& shape = layout.shape;
    TRY(positions_.begin(file, start, shape.vertices * sizeof(glm::vec3)));
    normals_at_ = TRY(file.extend(shape.has_normals ? shape.vertices * sizeof(glm::vec3) : 0));
    for (const GltfSemantic& semantic : layout.semantics) {
      const std::uint64_t at = TRY(file.extend(shape.vertices * semantic.stride()));
      attributes_.push_back({attribute_index_of(semantic, layout), semantic.stride(), at});
    }
    triangles_at_ = TRY(file.extend(shape.triangles * sizeof(glm::uvec3)));
    return {};
  }

  // Several threads may fill in parts at once.
  Result<void> fill(const files::OutputFile& file, const mesh::MeshPart& part) const {
    TRY(file.fill(positions_.place() + part.first_vertex * sizeof(glm::vec3), std::as_bytes(part.positions)));
    TRY(file.fill(normals_at_ + part.first_vertex * sizeof(glm::vec3), std::as_bytes(part.normals)));
    for (const Values& values : attributes_) {
      if (part.attributes.empty()) break;  // a part without vertices
      TRY(files::fill_records(file, values.at + part.first_vertex * values.stride, count_values(part, values.attribute),
                              values.stride, padded_values_of(part, values.attribute)));
    }
    return file.fill(triangles_at_ + part.first_triangle * sizeof(glm::uvec3), std::as_bytes(part.triangles));
  }

 private:
  struct Values {
    std::size_t attribute;  // index in the mesh
    std::size_t stride;
    std::uint64_t at;
  };

  FirstArray positions_;
  std::uint64_t normals_at_ = 0;
  std::vector<Values> attributes_;
  std::uint64_t triangles_at_ = 0;
};

// Writes each part to its place, and the JSON last.
class PartwiseGlbWriter final : public PartwiseWriter {
 public:
  PartwiseGlbWriter(const mesh::Mesh& head, const MeshWriteOptions& options, files::OutputFile& file)
      : json_(head, options), file_(file) {}

  Result<bool> begin_early(const mesh::MeshShape& estimate) override {
    const auto json_bytes = json_.glb_bytes_of(estimate);
    if (json_bytes) places_.begin_early(glb_start(0, 0).size() + *json_bytes + glb_binary_head(0).size());
    return json_bytes.has_value();
  }

  Result<bool> begin(const mesh::MeshShape& shape) override {
    if (!json_.begin(shape)) return false;
    json_bytes_ = TRY(json_.glb_bytes(file_));
    const std::string start = glb_start(json_bytes_, json_.binary_bytes());
    json_at_ = start.size();
    const std::string room(json_bytes_, ' ');
    TRY(places_.begin(file_, start + room + glb_binary_head(json_.binary_bytes()), json_.layout()));
    return true;
  }

  [[nodiscard]] std::vector<mesh::PartPass> passes() const override { return {{.attributes = json_.has_attributes()}}; }

  Result<void> take(const mesh::MeshPart& part) override {
    json_.measure(part);
    return places_.fill(file_, part);
  }

  [[nodiscard]] std::string facts() const override { return json_.facts(); }
  void add_facts(std::string_view facts) override { json_.add_facts(facts); }

  Result<void> finish(Notes& notes) override {
    const std::string text = json_.glb_text(json_bytes_, notes);
    return file_.fill(json_at_, std::as_bytes(std::span(text)));
  }

 private:
  PartwiseJson json_;
  files::OutputFile& file_;
  std::size_t json_bytes_ = 0;
  std::uint64_t json_at_ = 0;  // byte offset in the file
  PartPlaces places_;
};

// Writes the data of each part to its place, and then the model.
class PartwiseGltfWriter final : public PartwiseWriter {
 public:
  PartwiseGltfWriter(const mesh::Mesh& head, const MeshWriteOptions& options, files::OutputFile& model,
                     files::OutputFile& binary, const std::string& binary_name)
      : json_(head, options), model_(model), binary_(binary), uri_(uri_of(binary_name)) {}

  Result<bool> begin_early(const mesh::MeshShape& estimate) override {
    places_.begin_early(0);
    return json_.has_places(estimate);
  }

  Result<bool> begin(const mesh::MeshShape& shape) override {
    if (!json_.begin(shape)) return false;
    TRY(places_.begin(binary_, {}, json_.layout()));
    return true;
  }

  [[nodiscard]] std::vector<mesh::PartPass> passes() const override { return {{.attributes = json_.has_attributes()}}; }

  Result<void> take(const mesh::MeshPart& part) override {
    json_.measure(part);
    return places_.fill(binary_, part);
  }

  Result<void> finish(Notes& notes) override { return model_.write(json_.text(uri_, kGltfIndent, notes) + "\n"); }

 private:
  PartwiseJson json_;
  files::OutputFile& model_;
  files::OutputFile& binary_;
  std::string uri_;
  PartPlaces places_;
};

// Writes a stream: measures all positions first, because the JSON comes before them.
class OrderedGlbWriter final : public PartwiseWriter {
 public:
  OrderedGlbWriter(const mesh::Mesh& head, const MeshWriteOptions& options, files::OutputFile& file)
      : json_(head, options), file_(file) {}

  Result<bool> begin(const mesh::MeshShape& shape) override {
    has_normals_ = shape.has_normals;
    if (!json_.begin(shape)) return false;
    json_bytes_ = TRY(json_.glb_bytes(file_));
    return true;
  }

  // Has one pass for each attribute, because the file has one array after the other.
  [[nodiscard]] std::vector<mesh::PartPass> passes() const override {
    std::vector<mesh::PartPass> all{{.normals = false, .triangles = false},
                                    {.in_order = true, .normals = false, .triangles = false}};
    if (has_normals_) all.push_back({.in_order = true, .positions = false, .triangles = false});
    all.insert(all.end(), json_.layout().semantics.size(),
               {.in_order = true, .positions = false, .normals = false, .triangles = false, .attributes = true});
    all.push_back({.in_order = true, .positions = false, .normals = false});
    return all;
  }

  Result<void> begin_pass(std::size_t pass) override {
    measures_ = pass == 0;
    const std::size_t first_of_attributes = has_normals_ ? 3 : 2;
    if (pass >= first_of_attributes) semantic_ = pass - first_of_attributes;
    if (pass != 1) return {};
    TRY(file_.write(glb_start(json_bytes_, json_.binary_bytes())));
    TRY(file_.write(json_.glb_text(json_bytes_, notes_)));
    return file_.write(glb_binary_head(json_.binary_bytes()));
  }

  Result<void> take(const mesh::MeshPart& part) override {
    if (measures_) {
      json_.measure(part);
      return {};
    }
    TRY(file_.write(std::as_bytes(part.positions)));
    TRY(file_.write(std::as_bytes(part.normals)));
    if (!part.attributes.empty()) {
      const GltfSemantic& semantic = json_.layout().semantics[semantic_];
      const std::size_t attribute = attribute_index_of(semantic, json_.layout());
      TRY(files::write_records(file_, count_values(part, attribute), semantic.stride(),
                               padded_values_of(part, attribute)));
    }
    return file_.write(std::as_bytes(part.triangles));
  }

  Result<void> finish(Notes& notes) override {
    notes.insert(notes.end(), notes_.begin(), notes_.end());
    return {};
  }

 private:
  PartwiseJson json_;
  files::OutputFile& file_;
  std::size_t json_bytes_ = 0;
  bool has_normals_ = false;
  bool measures_ = false;     // true in the first pass
  std::size_t semantic_ = 0;  // index of the attribute of the pass
  Notes notes_;               // notes about the JSON
};

class GltfWriter final : public FormatWriter {
 public:
  GltfWriter(const MeshWriteOptions& options, const Context& context, files::OutputFile& model,
             files::OutputFile& binary, const std::string& binary_name)
      : options_(options), context_(context), model_(model), binary_(binary), uri_(uri_of(binary_name)) {}

  Result<void> add(const mesh::Mesh& mesh, Notes& notes) override {
    const auto part = TRY(GltfPart::make(mesh, options_, context_, notes));
    packed_.push_back(part.packed != nullptr ? part.packed->facts : PackedFacts{});
    model_json_.add(part);
    return write_part(part, binary_);
  }

  Result<void> finish(Notes& notes) override { return model_.write(model_json_.json(uri_, kGltfIndent, notes) + "\n"); }

  [[nodiscard]] std::vector<PackedFacts> packed() const override { return packed_; }

 private:
  MeshWriteOptions options_;
  Context context_;
  files::OutputFile& model_;
  files::OutputFile& binary_;
  std::string uri_;
  GltfModel model_json_{options_.placement};
  std::vector<PackedFacts> packed_;
};

}  // namespace

std::unique_ptr<FormatWriter> make_glb_writer(const MeshWriteOptions& options, const Context& context,
                                              files::OutputFile& file) {
  return std::make_unique<GlbWriter>(options, context, file);
}

std::unique_ptr<FormatWriter> make_streamed_glb_writer(const MeshWriteOptions& options, const Context& context,
                                                       files::OutputFile& file) {
  return std::make_unique<MovingGlbWriter>(options, context, file);
}

std::unique_ptr<PartwiseWriter> make_partwise_glb_writer(const mesh::Mesh& head, const MeshWriteOptions& options,
                                                         files::OutputFile& file) {
  return std::make_unique<PartwiseGlbWriter>(head, options, file);
}

std::unique_ptr<PartwiseWriter> make_ordered_glb_writer(const mesh::Mesh& head, const MeshWriteOptions& options,
                                                        files::OutputFile& file) {
  return std::make_unique<OrderedGlbWriter>(head, options, file);
}

std::unique_ptr<PartwiseWriter> make_partwise_gltf_writer(const mesh::Mesh& head, const MeshWriteOptions& options,
                                                          files::OutputFile& model, files::OutputFile& binary,
                                                          const std::string& binary_name) {
  return std::make_unique<PartwiseGltfWriter>(head, options, model, binary, binary_name);
}

std::unique_ptr<FormatWriter> make_gltf_writer(const MeshWriteOptions& options, const Context& context,
                                               files::OutputFile& model, files::OutputFile& binary,
                                               const std::string& binary_name) {
  return std::make_unique<GltfWriter>(options, context, model, binary, binary_name);
}

}  // namespace isoextract::mesh_io
