#include "mesh_io/mesh_writer.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <mutex>
#include <type_traits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/pages.hpp"
#include "mesh_io/write/attempt.hpp"
#include "mesh_io/write/coordinate_rounding.hpp"
#include "mesh_io/write/mesh_format_writers.hpp"
#include "mesh_io/write/partwise_writer.hpp"
#include "mesh_io/write/vertex_order.hpp"

namespace isoextract::mesh_io {
namespace {

namespace fs = std::filesystem;

std::string names_of_formats(bool MeshFormatInfo::*property) {
  std::string names;
  for (const MeshFormatInfo& info : mesh_formats()) {
    if (info.*property) names += fmt::format("{}{}", names.empty() ? "" : ", ", info.name);
  }
  return names;
}

Result<void> check(std::size_t meshes, const fs::path& path, const MeshWriteOptions& options) {
  const MeshFormatInfo& info = mesh_format_info(options.format);
  if (auto sound = check_packing(options.packing, options.format); !sound) {
    sound.error().message = fmt::format("{}: {}", path.string(), sound.error().message);
    return sound;
  }
  if (options.ascii && !info.has_text_option) {
    return fail(ErrorCode::usage, fmt::format("{}: the format {} has no text form", path.string(), info.name),
                {Remedy::set, Setting::mesh_format, names_of_formats(&MeshFormatInfo::has_text_option)});
  }
  if (meshes != 1 && !info.can_hold_several_meshes) {
    return fail(ErrorCode::usage,
                fmt::format("{}: the format {} holds one mesh, found {} meshes", path.string(), info.name, meshes),
                {Remedy::set, Setting::mesh_format, names_of_formats(&MeshFormatInfo::can_hold_several_meshes)});
  }
  if (info.can_stream) return {};
  if (files::is_stream(path)) {
    return fail(ErrorCode::usage,
                fmt::format("{}: the format {} consists of two files, which "
                            "cannot go to a stream",
                            path.string(), info.name),
                {Remedy::set, Setting::mesh_format, names_of_formats(&MeshFormatInfo::can_stream)});
  }
  if (path.extension() == ".bin") {
    return fail(ErrorCode::usage,
                fmt::format("{}: the second file of the format {}, with the "
                            "data, would have the same name",
                            path.string(), info.name),
                "use a name that ends in .gltf");
  }
  return {};
}

// Returns whether meshes wait in memory, until finish() or until they take most_held_bytes().
bool holds_meshes(const fs::path& path, const MeshWriteOptions& options) {
  return !mesh_format_info(options.format).writes_each_mesh_at_once || files::is_stream(path) ||
         (options.packing.quantizes() && !options.packing.box);
}

// Returns whether the parts of a mesh can come in any order: the file offset of a part does not depend on other parts.
// Face normals rule this out, as they need the vertices of the next part.
bool takes_any_order(const fs::path& path, const MeshWriteOptions& options) {
  return has_fixed_places(options.format, options.ascii) && !options.flat_normals && !files::is_stream(path);
}

std::uint64_t array_bytes(const mesh::Mesh& mesh) {
  std::uint64_t bytes = mesh.positions.size_bytes() + mesh.normals.size_bytes() + mesh.triangles.size_bytes();
  for (const mesh::Attribute& attribute : mesh.attributes) bytes += attribute.values.size_bytes();
  return bytes;
}

// Frees the arrays and the values of attributes. The format still needs the names of the mesh and of its attributes.
void free_arrays(mesh::Mesh& mesh) {
  constexpr std::uint64_t kLarge = std::uint64_t{4} << 20U;  // worth the calls of the system
  const bool is_large = array_bytes(mesh) >= kLarge;
  mesh.positions = {};
  mesh.normals = {};
  mesh.edges = {};
  mesh.triangles = {};
  for (mesh::Attribute& attribute : mesh.attributes) attribute.values = {};
  mesh.memory.release();
  if (is_large) release_free_memory();
}

// Writes PLY or STL, which hold one mesh.
class OneMeshWriter final : public FormatWriter {
 public:
  using Write = Result<void> (*)(const mesh::Mesh&, const MeshWriteOptions&, files::OutputFile&, Notes&);

  OneMeshWriter(Write write, const MeshWriteOptions& options, files::OutputFile& file)
      : write_(write), options_(options), file_(file) {}

  Result<void> add(const mesh::Mesh& mesh, Notes& notes) override { return write_(mesh, options_, file_, notes); }
  Result<void> finish(Notes& /*notes*/) override { return {}; }

 private:
  Write write_;
  MeshWriteOptions options_;
  files::OutputFile& file_;
};

// Returns the box around all meshes, in world coordinates.
mesh::Bounds bounds_of(std::span<const mesh::Mesh> meshes) {
  std::optional<mesh::Bounds> all;
  for (const mesh::Mesh& mesh : meshes) {
    if (mesh.positions.empty()) continue;
    const mesh::Bounds bounds = mesh::measure_bounds(mesh);
    all = all ? mesh::Bounds{glm::min(all->min, bounds.min), glm::max(all->max, bounds.max)} : bounds;
  }
  return all.value_or(mesh::Bounds());
}

}  // namespace

Result<void> check_packing(const MeshPacking& packing, MeshFormat format) {
  const std::string_view name = mesh_format_info(format).name;
  const bool draco = packing.compression == Compression::draco || format == MeshFormat::drc;
  if (packing.compression == Compression::draco && !is_gltf(format) && format != MeshFormat::drc) {
    return fail(ErrorCode::usage, fmt::format("the format {} does not support Draco compression", name),
                {Remedy::set, Setting::mesh_format, "glb, gltf or drc"});
  }
  if ((packing.quantize || packing.compression == Compression::meshopt) && !is_gltf(format)) {
    return fail(ErrorCode::usage,
                fmt::format("the format {} does not support {}", name,
                            packing.quantize ? "quantized 16-bit positions" : "meshoptimizer compression"),
                {Remedy::set, Setting::mesh_format, "glb or gltf"});
  }
  if (draco && packing.quantize)
    return fail(ErrorCode::usage, "Draco already quantizes positions, with its own number of bits");
  if (draco && packing.optimize_order)
    return fail(ErrorCode::usage,
                "Draco orders vertices and triangles by "
                "itself: an optimized order has no effect");
  if (!packing.position_bits) return {};
  if (!draco) return fail(ErrorCode::usage, "a number of position bits requires Draco compression");
  if (*packing.position_bits < kMinPositionBits || *packing.position_bits > kMaxPositionBits) {
    return fail(ErrorCode::usage, fmt::format("expected {} to {} position bits, found {}", kMinPositionBits,
                                              kMaxPositionBits, *packing.position_bits));
  }
  return {};
}

struct MeshWriter::State {
  fs::path path;
  MeshWriteOptions options;
  Context context;
  bool holds = false;            // holds all meshes until finish()
  std::vector<mesh::Mesh> held;  // meshes that are not written yet
  std::uint64_t held_bytes = 0;  // of the arrays of `held`
  std::size_t count = 0;         // number of meshes added
  std::optional<files::OutputFile> file;
  std::optional<files::OutputFile> binary;  // the .bin of .gltf
  std::unique_ptr<FormatWriter> format;
  mesh::Mesh head;                        // the mesh that comes in parts, without its arrays
  std::unique_ptr<PartwiseWriter> parts;  // writes these parts; null if all meshes come whole
  bool is_early = false;                  // the writer takes vertices before begin_parts()
  Ranks* ranks = nullptr;                 // processes that write the parts; null: one process
  std::vector<std::string> left_out;      // names of attributes that the format cannot store
  Notes notes;
  std::optional<Error> failure;
  std::mutex failure_mutex;  // guards `failure` in attempt_part()

  template <class Step>
  [[nodiscard]] std::invoke_result_t<Step> attempt(Step step) {
    return mesh_io::attempt(failure, context, path, std::move(step));
  }
  // Like attempt(); several threads may call it at once.
  template <class Step>
  [[nodiscard]] Result<void> attempt_part(Step step);

  [[nodiscard]] Result<void> check_vertex_precision(const mesh::Mesh& mesh);
  [[nodiscard]] fs::path binary_path() const { return fs::path(path).replace_extension(".bin"); }
  [[nodiscard]] Result<void> open_file();
  [[nodiscard]] Result<void> open();
  [[nodiscard]] std::unique_ptr<PartwiseWriter> make_partwise_writer();
  [[nodiscard]] Result<std::unique_ptr<PartwiseWriter>> begin_parts(const mesh::MeshShape& shape);
  [[nodiscard]] bool takes_parts(const mesh::Mesh& one, const mesh::MeshShape& shape, const Ranks* others) const;
  void drop_early();
  [[nodiscard]] Result<bool> join_ranks(const mesh::MeshShape& shape);
  [[nodiscard]] Result<void> finish_parts();
  [[nodiscard]] Result<void> write(const mesh::Mesh& mesh);
  [[nodiscard]] Result<void> write_held();
  [[nodiscard]] Result<MeshWriteResult> finish(std::span<const mesh::Mesh> last);
  [[nodiscard]] std::string left_out_note() const;
};

template <class Step>
Result<void> MeshWriter::State::attempt_part(Step step) {
  std::optional<Error> found;
  {
    const std::lock_guard lock(failure_mutex);
    found = failure;
  }
  auto done = mesh_io::attempt(found, context, path, std::move(step));
  if (done) return done;
  const std::lock_guard lock(failure_mutex);
  if (!failure) failure = std::move(found);
  return done;
}

// Fails if rounding would destroy the mesh; adds a note if triangles collapse.
Result<void> MeshWriter::State::check_vertex_precision(const mesh::Mesh& mesh) {
  const auto collapsed = check_coordinate_rounding(mesh, path, options.format);
  if (!collapsed) return tl::unexpected<Error>(collapsed.error());
  if (*collapsed > 0) notes.push_back(rounding_note(path, *collapsed, mesh.triangles.size()));
  return {};
}

// For .gltf, opens the .bin, too.
Result<void> MeshWriter::State::open_file() {
  auto opened = files::OutputFile::create(path);
  if (!opened) return tl::unexpected<Error>(std::move(opened.error()));
  file = std::move(*opened);
  if (options.hash_files) file->keep_hash();
  if (options.format != MeshFormat::gltf) return {};
  auto data = files::OutputFile::create(binary_path());
  if (!data) return tl::unexpected<Error>(std::move(data.error()));
  binary = std::move(*data);
  if (options.hash_files) binary->keep_hash();
  return {};
}

// Opens the files and makes the format's writer, on the first call.
Result<void> MeshWriter::State::open() {
  if (format != nullptr || parts != nullptr) return {};
  if (!file) TRY(open_file());
  switch (options.format) {
    case MeshFormat::glb: format = make_glb_writer(options, context, *file); break;
    case MeshFormat::ply: format = std::make_unique<OneMeshWriter>(write_ply, options, *file); break;
    case MeshFormat::stl: format = std::make_unique<OneMeshWriter>(write_stl, options, *file); break;
    case MeshFormat::obj: format = make_obj_writer(options, context, *file); break;
    case MeshFormat::drc: format = make_drc_writer(options, context, *file); break;
    case MeshFormat::gltf:
      format = make_gltf_writer(options, context, *file, *binary, binary_path().filename().string());
  }
  return {};
}

Result<void> MeshWriter::State::write(const mesh::Mesh& mesh) {
  TRY(open());
  if (!mesh_format_info(options.format).has_attributes) {
    for (const mesh::Attribute& attribute : mesh.attributes) {
      std::string name = fmt::format("'{}'", attribute.name);
      if (std::find(left_out.begin(), left_out.end(), name) == left_out.end()) left_out.push_back(std::move(name));
    }
  }
  auto added = format->add(mesh, notes);
  // Errors of packing do not name the file.
  if (!added && options.packing.packs() &&
      !added.error().message.starts_with(fs::path(path).replace_extension().string())) {
    added.error().message = fmt::format("{}: {}", path.string(), added.error().message);
  }
  return added;
}

// Writes the held meshes of a GLB, and holds no later ones.
Result<void> MeshWriter::State::write_held() {
  TRY(open_file());
  format = make_streamed_glb_writer(options, context, *file);
  holds = false;
  for (mesh::Mesh& mesh : held) TRY(write(std::exchange(mesh, {})));
  held.clear();
  return {};
}

std::string MeshWriter::State::left_out_note() const {
  return fmt::format(
      "{} cannot store vertex attributes: the writer omits {}; "
      "{} store attributes",
      mesh_format_info(options.format).name, fmt::join(left_out, ", "),
      names_of_formats(&MeshFormatInfo::has_attributes));
}

// `last` holds the meshes that are not written yet, those in `held` or meshes of the caller.
Result<MeshWriteResult> MeshWriter::State::finish(std::span<const mesh::Mesh> last) {
  if (count == 0) drop_early();
  auto done = check(count, path, options);
  if (options.packing.quantizes() && !options.packing.box) options.packing.box = bounds_of(last);
  if (done) done = open();
  for (std::size_t m = 0; m < last.size() && done; ++m) {
    done = write(last[m]);
    if (m < held.size() && options.packing.packs()) free_arrays(held[m]);
  }
  if (done) done = parts != nullptr ? finish_parts() : format->finish(notes);
  const bool has_binary = done && binary && binary->bytes_written() > 0;
  const bool is_committed = ranks != nullptr && !ranks->is_first();
  if (done && !is_committed) done = has_binary ? files::OutputFile::commit_pair(*binary, *file) : file->commit();
  if (!done) return tl::unexpected<Error>(std::move(done.error()));
  if (!left_out.empty()) notes.insert(notes.begin(), {NoteId::attribute_left_out, left_out_note()});
  MeshWriteResult result{{{path.string(), file->bytes_written(), file->hash()}}, std::move(notes), {}};
  if (options.packing.packs()) result.packed = format->packed();
  if (has_binary) {
    result.files.push_back({binary_path().string(), binary->bytes_written(), binary->hash()});
  }
  return result;
}

std::uint64_t most_held_bytes(const fs::path& path, const MeshWriteOptions& options, const Context& context) {
  if (!holds_meshes(path, options)) return 0;
  const bool may_move = options.format == MeshFormat::glb && !options.packing.packs() && !files::is_stream(path);
  if (!may_move) return std::numeric_limits<std::uint64_t>::max();
  constexpr std::uint64_t kMost = std::uint64_t{64} << 20;  // beyond it, moving the data may double the bytes written
  return std::min(kMost, context.memory().limit() / 8);
}

MeshWriter::MeshWriter(const fs::path& path, const MeshWriteOptions& options, const Context& context)
    : state_(std::make_unique<State>()) {
  state_->path = path;
  state_->options = options;
  state_->context = context;
  if (options.format == MeshFormat::drc && options.packing.compression == Compression::none) {
    state_->options.packing.compression = Compression::draco;
  }
  state_->holds = holds_meshes(path, state_->options);
}

MeshWriter::MeshWriter(MeshWriter&&) noexcept = default;
MeshWriter& MeshWriter::operator=(MeshWriter&&) noexcept = default;
MeshWriter::~MeshWriter() = default;

Result<void> MeshWriter::add(mesh::Mesh mesh) {
  State& state = *state_;
  return state.attempt([&]() -> Result<void> {
    if (state.count == 0) state.drop_early();
    TRY(check(++state.count, state.path, state.options));
    TRY(state.check_vertex_precision(mesh));
    if (state.options.packing.optimize_order) {
      TRY(optimize_order(mesh, state.context));
    }
    state.held_bytes += array_bytes(mesh);
    const std::uint64_t most = most_held_bytes(state.path, state.options, state.context);
    if (state.holds && !state.held.empty() && state.held_bytes > most) TRY(state.write_held());
    if (!state.holds) return state.write(mesh);
    state.held.push_back(std::move(mesh));
    return {};
  });
}

// Expects a format that takes parts, and open files.
std::unique_ptr<PartwiseWriter> MeshWriter::State::make_partwise_writer() {
  const bool any = takes_any_order(path, options);
  switch (options.format) {
    case MeshFormat::glb: return (any ? make_partwise_glb_writer : make_ordered_glb_writer)(head, options, *file);
    case MeshFormat::ply:
      return (any ? make_partwise_ply_writer : make_ordered_ply_writer)(head, options, context, *file);
    case MeshFormat::obj: return make_partwise_obj_writer(head, options, context, *file);
    case MeshFormat::stl: return make_partwise_stl_writer(head, options, context, *file);
    case MeshFormat::gltf:
      return make_partwise_gltf_writer(head, options, *file, *binary, binary_path().filename().string());
    case MeshFormat::drc: break;
  }
  return nullptr;
}

// Returns null if the format declines the mesh; it has then written nothing but early vertices.
Result<std::unique_ptr<PartwiseWriter>> MeshWriter::State::begin_parts(const mesh::MeshShape& shape) {
  auto writer = is_early ? std::move(parts) : make_partwise_writer();
  const bool takes = TRY(writer->begin(shape));
  if (!takes) writer = nullptr;
  return writer;
}

// Opens the file on all ranks. Rank 0 makes it, with its full size, before other ranks open it.
Result<bool> MeshWriter::State::join_ranks(const mesh::MeshShape& shape) {
  if (ranks->is_first()) {
    file = TRY(files::OutputFile::create_shared(path));
    if (options.hash_files) file->keep_hash();
    parts = TRY(begin_parts(shape));
    if (parts == nullptr) file.reset();
  }
  const auto told = TRY(ranks->gather(parts != nullptr ? file->shared_name() : std::string()));
  if (told.front().empty()) return false;
  if (ranks->is_first()) return true;
  file = TRY(files::OutputFile::join(path, told.front()));
  parts = TRY(begin_parts(shape));
  return parts != nullptr;
}

Result<void> MeshWriter::State::finish_parts() {
  if (ranks == nullptr) return parts->finish(notes);
  // Ranks above 0 close the file before rank 0 renames it, so that their bytes are in the file on network file systems,
  // too.
  if (!ranks->is_first()) {
    TRY(file->commit());
  }
  const auto facts = TRY(ranks->gather(parts->facts()));
  if (!ranks->is_first()) return {};
  for (std::size_t r = 1; r < facts.size(); ++r) parts->add_facts(facts[r]);
  return parts->finish(notes);
}

bool MeshWriter::State::takes_parts(const mesh::Mesh& one, const mesh::MeshShape& shape, const Ranks* others) const {
  const bool splits_triangles = options.flat_normals && is_gltf(options.format);
  const bool omits_attributes = !one.attributes.empty() && !mesh_format_info(options.format).has_attributes;
  const bool has_stream = options.format == MeshFormat::gltf && files::is_stream(binary_path());
  const bool needs_whole_mesh = !mesh_format_info(options.format).takes_parts || splits_triangles || has_stream ||
                                options.packing.packs() || options.packing.optimize_order || omits_attributes ||
                                shape.origin != glm::dvec3(0) || (others != nullptr && !takes_any_order(path, options));
  return !needs_whole_mesh && count == 0;
}

// Forgets the vertices that came before begin_parts(), with the file.
void MeshWriter::State::drop_early() {
  if (!std::exchange(is_early, false)) return;
  parts.reset();
  file.reset();
  binary.reset();
}

Result<bool> MeshWriter::begin_early(mesh::Mesh head, const mesh::MeshShape& estimate) {
  State& state = *state_;
  state.drop_early();
  const bool has_places = state.options.format == MeshFormat::gltf || takes_any_order(state.path, state.options);
  // The normals of glTF follow all positions, so they have no place yet.
  const bool has_no_place = is_gltf(state.options.format) && estimate.has_normals;
  if (!has_places || has_no_place || !state.takes_parts(head, estimate, nullptr)) return false;
  return state.attempt([&]() -> Result<bool> {
    TRY(check(1, state.path, state.options));
    state.head = std::move(head);
    TRY(state.open_file());
    state.parts = state.make_partwise_writer();
    state.is_early = true;
    const bool takes = TRY(state.parts->begin_early(estimate));
    if (!takes) state.drop_early();
    return takes;
  });
}

Result<bool> MeshWriter::begin_parts(mesh::Mesh head, const mesh::MeshShape& shape, Ranks* ranks) {
  State& state = *state_;
  if (!state.takes_parts(head, shape, ranks)) {
    state.drop_early();
    return false;
  }
  return state.attempt([&]() -> Result<bool> {
    TRY(check(1, state.path, state.options));
    state.head = std::move(head);
    state.ranks = ranks;
    if (ranks != nullptr) {
      state.drop_early();
      const bool takes = TRY(state.join_ranks(shape));
      if (!takes) state.ranks = nullptr;
    } else {
      if (!state.is_early) TRY(state.open_file());
      state.parts = TRY(state.begin_parts(shape));
      if (state.parts == nullptr) state.drop_early();
    }
    state.is_early = false;
    if (state.parts != nullptr) state.count = 1;
    return state.parts != nullptr;
  });
}

std::vector<mesh::PartPass> MeshWriter::part_passes() const { return state_->parts->passes(); }

Result<void> MeshWriter::begin_pass(std::size_t pass) const {
  return state_->attempt_part([&] { return state_->parts->begin_pass(pass); });
}

Result<void> MeshWriter::take_part(const mesh::MeshPart& part) const {
  return state_->attempt_part([&] { return state_->parts->take(part); });
}

Result<MeshWriteResult> MeshWriter::finish() {
  return state_->attempt([&] { return state_->finish(state_->held); });
}

Result<MeshWriteResult> write_meshes(std::span<const mesh::Mesh> meshes, const fs::path& path,
                                     const MeshWriteOptions& options, const Context& context) {
  MeshWriter writer(path, options, context);
  if (options.packing.optimize_order) {
    Result<void> added;
    for (std::size_t m = 0; m < meshes.size() && added; ++m) added = writer.add(mesh::copy(meshes[m]));
    return writer.finish();
  }
  MeshWriter::State& state = *writer.state_;
  state.count = meshes.size();
  return state.attempt([&]() -> Result<MeshWriteResult> {
    for (const mesh::Mesh& mesh : meshes) {
      TRY(state.check_vertex_precision(mesh));
    }
    return state.finish(meshes);
  });
}

}  // namespace isoextract::mesh_io
