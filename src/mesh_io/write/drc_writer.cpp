// Draco files: one bit stream, with attribute names and the generator as metadata. Coordinates are world coordinates,
// since the format has no nodes.
#include <utility>

#include <fmt/format.h>

#include "mesh_io/write/draco_packing.hpp"
#include "mesh_io/write/mesh_format_writers.hpp"

namespace isoextract::mesh_io {
namespace {

class DrcWriter final : public FormatWriter {
 public:
  DrcWriter(const MeshWriteOptions& options, const Context& context, files::OutputFile& file)
      : options_(options), context_(context), file_(file) {}

  Result<void> add(const mesh::Mesh& mesh, Notes& notes) override {
    if (mesh.triangles.empty()) {
      return fail(ErrorCode::output, fmt::format("{}: Draco cannot store a mesh without triangles", file_.shown_name()),
                  {Remedy::set, Setting::mesh_format, "ply or glb"});
    }
    const GltfPart part(mesh, options_.flat_normals, notes);
    DracoPacking packing;
    packing.lattice = choose_lattice(options_.packing, *options_.packing.box, LatticeUse::float_world);
    packing.flat_normals = options_.flat_normals;
    packing.semantics = part.semantics;
    packing.is_file = true;
    packing.placement = options_.placement;
    auto packed = TRY(pack_with_draco(mesh, packing, context_));
    packed.facts.bytes_before = part.bytes();
    facts_.push_back(packed.facts);
    return file_.write(packed.bytes);
  }

  Result<void> finish(Notes& /*notes*/) override { return {}; }

  [[nodiscard]] std::vector<PackedFacts> packed() const override { return facts_; }

 private:
  MeshWriteOptions options_;
  Context context_;
  files::OutputFile& file_;
  std::vector<PackedFacts> facts_;
};

}  // namespace

std::unique_ptr<FormatWriter> make_drc_writer(const MeshWriteOptions& options, const Context& context,
                                              files::OutputFile& file) {
  return std::make_unique<DrcWriter>(options, context, file);
}

}  // namespace isoextract::mesh_io
