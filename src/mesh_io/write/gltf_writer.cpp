// glTF 2.0 (ISO/IEC 12113): TinyGLTF builds the model and its JSON (gltf_model); the binary data goes from the meshes'
// buffers directly to the file.
// Each mesh is laid out before it is written, so that the JSON knows every offset. In a GLB, whose JSON precedes the
// data, all meshes are laid out first.
#include <limits>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "mesh_io/write/glb_container.hpp"
#include "mesh_io/write/gltf_model.hpp"
#include "mesh_io/write/gltf_packed_part.hpp"
#include "mesh_io/write/gltf_part.hpp"
#include "mesh_io/write/mesh_format_writers.hpp"

namespace isoextract::mesh_io {
namespace {

class GlbWriter final : public FormatWriter {
 public:
  GlbWriter(const MeshWriteOptions& options, const Context& context, files::OutputFile& file)
      : options_(options), context_(context), file_(file) {}

  Result<void> add(const mesh::Mesh& mesh, Notes& notes) override {
    auto part = TRY(GltfPart::make(mesh, options_, context_, notes));
    parts_.push_back(std::move(part));
    return {};
  }

  Result<void> finish(Notes& notes) override {
    std::uint64_t binary_bytes = 0;
    for (const GltfPart& part : parts_) binary_bytes += part.bytes();
    // Checks the length before measuring the bounds, which would be wasted on a file that is too large, and exactly
    // below.
    TRY(check_length(glb_bytes(0, binary_bytes)));
    GltfModel model(options_.placement);
    for (const GltfPart& part : parts_) model.add(part);
    std::string text = model.json({}, -1, notes);
    pad_glb_json(text);
    TRY(check_length(glb_bytes(text.size(), binary_bytes)));
    auto written = file_.write(glb_start(text.size(), binary_bytes));
    if (written) written = file_.write(text);
    if (!written || binary_bytes == 0) return written;
    written = file_.write(glb_binary_head(binary_bytes));
    for (std::size_t p = 0; p < parts_.size() && written; ++p) written = write_part(parts_[p], file_);
    return written;
  }

  [[nodiscard]] std::vector<PackedFacts> packed() const override {
    std::vector<PackedFacts> facts;
    for (const GltfPart& part : parts_) facts.push_back(part.packed != nullptr ? part.packed->facts : PackedFacts{});
    return facts;
  }

 private:
  [[nodiscard]] Result<void> check_length(std::uint64_t length) const {
    if (length <= std::numeric_limits<std::uint32_t>::max()) return {};
    return fail(ErrorCode::output,
                fmt::format("{}: a .glb holds less than 4 GiB; this one needs {} bytes", file_.shown_name(), length),
                {Remedy::set, Setting::mesh_format, "gltf or ply"});
  }

  MeshWriteOptions options_;
  Context context_;
  files::OutputFile& file_;
  std::vector<GltfPart> parts_;
};

class GltfWriter final : public FormatWriter {
 public:
  GltfWriter(const MeshWriteOptions& options, const Context& context, files::OutputFile& model,
             files::OutputFile& binary, const std::string& binary_name)
      : options_(options), context_(context), model_(model), binary_(binary) {
    for (const char c : binary_name) {
      const bool unreserved = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                              std::string_view("-._~").find(c) != std::string_view::npos;  // RFC 3986, 2.3
      uri_ += unreserved ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
  }

  Result<void> add(const mesh::Mesh& mesh, Notes& notes) override {
    const auto part = TRY(GltfPart::make(mesh, options_, context_, notes));
    packed_.push_back(part.packed != nullptr ? part.packed->facts : PackedFacts{});
    model_json_.add(part);
    return write_part(part, binary_);
  }

  Result<void> finish(Notes& notes) override {
    constexpr int kIndent = 2;
    return model_.write(model_json_.json(uri_, kIndent, notes) + "\n");
  }

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

std::unique_ptr<FormatWriter> make_gltf_writer(const MeshWriteOptions& options, const Context& context,
                                               files::OutputFile& model, files::OutputFile& binary,
                                               const std::string& binary_name) {
  return std::make_unique<GltfWriter>(options, context, model, binary, binary_name);
}

}  // namespace isoextract::mesh_io
