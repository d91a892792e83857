#include "mesh_io/mesh_reader.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <limits>
#include <new>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/allocation_error.hpp"
#include "base/checked.hpp"
#include "base/hash.hpp"
#include "base/number_text.hpp"
#include "mesh/local_origin.hpp"
#include "mesh_io/detail/json_tree.hpp"
#include "mesh_io/detail/placement_entry.hpp"
#include "mesh_io/read/gltf_json.hpp"
#include "mesh_io/read/mesh_format_readers.hpp"

namespace isoextract::mesh_io {
namespace {

using Reader = FileSurface (*)(const MeshSource&);

// Finds the reader by the magic bytes; null if there are none.
Reader reader_by_mark(std::string_view text) {
  if (text.starts_with("glTF")) return read_glb;
  if (text.starts_with("DRACO")) return read_drc;
  if (text.starts_with("ply\n") || text.starts_with("ply\r")) return read_ply;
  return nullptr;
}

bool is_obj_text(std::string_view text) {
  constexpr std::array<std::string_view, 8> kKeywords{"v", "vn", "vt", "o", "g", "s", "mtllib", "usemtl"};
  TextScanner lines(text);
  while (lines.next_line()) {
    const std::string_view word = lines.word();
    if (!word.empty() && !word.starts_with('#')) return std::ranges::find(kKeywords, word) != kKeywords.end();
  }
  return false;
}

// Finds the reader by the beginning of content without magic bytes, for files without a mesh extension, such as
// standard input. `size` is the size of the whole file.
Reader reader_by_beginning(std::string_view text, std::uint64_t size) {
  constexpr std::size_t kStlHeader = 80;
  constexpr std::uint64_t kStlTriangle = 50;
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && text[first] == '{') return read_gltf;
  std::uint32_t triangles = 0;
  if (text.size() >= kStlHeader + sizeof(triangles)) {
    std::memcpy(&triangles, text.data() + kStlHeader, sizeof(triangles));
    if (size == kStlHeader + sizeof(triangles) + kStlTriangle * triangles) return read_stl;
  }
  if (text.starts_with("solid")) return read_stl;
  return is_obj_text(text) ? read_obj : nullptr;
}

constexpr std::array<std::pair<MeshFormat, Reader>, 6> kReaders{{{MeshFormat::obj, read_obj},
                                                                 {MeshFormat::stl, read_stl},
                                                                 {MeshFormat::ply, read_ply},
                                                                 {MeshFormat::glb, read_glb},
                                                                 {MeshFormat::gltf, read_gltf},
                                                                 {MeshFormat::drc, read_drc}}};

Reader reader_of(const MeshSource& source) {
  const std::string_view text = source.text();
  if (const Reader marked = reader_by_mark(text)) return marked;
  const auto by_extension = mesh_format_by_path(source.file.path());
  if (by_extension) {
    const auto entry = std::ranges::find(kReaders, *by_extension, &std::pair<MeshFormat, Reader>::first);
    if (entry != kReaders.end()) return entry->second;
  } else if (const Reader found = reader_by_beginning(text, text.size())) {
    return found;
  }
  throw DamagedMesh(fmt::format("expected a mesh ({}), found a file that starts with '{}'", mesh_extensions(),
                                files::printable(text, 16)));
}

// Chooses the local origin: the usual one, or zero if the usual one would round coordinates that are all float32
// numbers.
glm::dvec3 choose_origin(std::span<const glm::dvec3> positions, const glm::dvec3& low, const glm::dvec3& high) {
  const glm::dvec3 wanted = mesh::choose_local_origin(low, high);
  const auto are_floats = [&](const glm::dvec3& origin) {
    return std::ranges::all_of(positions,
                               [&](const glm::dvec3& p) { return glm::dvec3(glm::vec3(p - origin)) == p - origin; });
  };
  if (!are_floats(glm::dvec3(0))) return wanted;
  const auto rounded = glm::dvec3(glm::vec3(wanted));
  return are_floats(rounded) ? rounded : glm::dvec3(0);
}

mesh::Mesh mesh_of(const FileSurface& surface, const Context& context) {
  MemoryUse memory(context);
  memory.take(surface.positions.capacity() * sizeof(glm::dvec3) + surface.positions.size() * sizeof(glm::vec3));
  memory.take((surface.triangles.capacity() + surface.triangles.size()) * sizeof(glm::uvec3));
  for (const FileAttribute& attribute : surface.attributes) {
    memory.take(attribute.values.capacity() + attribute.values.size());
  }
  mesh::Mesh mesh;
  for (const auto& [kind, values] : surface.attributes) {
    if (values.size() != surface.positions.size() * kind.stride()) {
      throw DamagedMesh(fmt::format("expected a value of '{}' for each of {} vertices, found {} values", kind.name,
                                    surface.positions.size(), values.size() / kind.stride()));
    }
    mesh.attributes.push_back(kind.without_values());
    Buffer<std::byte>& copy = mesh.attributes.back().values;
    copy = Buffer<std::byte>(values.size());
    std::copy(values.begin(), values.end(), copy.begin());
  }
  mesh.positions = Buffer<glm::vec3>(surface.positions.size());
  mesh.triangles = Buffer<glm::uvec3>(surface.triangles.size());
  std::copy(surface.triangles.begin(), surface.triangles.end(), mesh.triangles.begin());
  if (surface.positions.empty()) return mesh;

  glm::dvec3 low = surface.positions.front();
  glm::dvec3 high = low;
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    const glm::dvec3& p = surface.positions[v];
    if (!is_finite(p)) {
      throw DamagedMesh(fmt::format("expected finite coordinates, found ({}, {}, {}) at vertex {}, counted from 0", p.x,
                                    p.y, p.z, v));
    }
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  mesh.origin = surface.origin ? *surface.origin : choose_origin(surface.positions, low, high);
  if (!is_finite(mesh.origin)) {
    throw DamagedMesh(fmt::format("expected a finite origin of the mesh, found ({}, {}, {})", mesh.origin.x,
                                  mesh.origin.y, mesh.origin.z));
  }
  const glm::dvec3 shift = surface.origin ? glm::dvec3(0) : mesh.origin;
  const glm::dvec3 farthest = glm::max(glm::abs(low - shift), glm::abs(high - shift));
  if (!(std::max({farthest.x, farthest.y, farthest.z}) <= static_cast<double>(std::numeric_limits<float>::max()))) {
    throw DamagedMesh(fmt::format("the coordinates extend from {} to {}, too far from the mesh's origin for float32",
                                  point_text(low, 9), point_text(high, 9)));
  }
  std::transform(surface.positions.begin(), surface.positions.end(), mesh.positions.begin(),
                 [&](const glm::dvec3& p) { return glm::vec3(p - shift); });
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3& corners = mesh.triangles[t];
    const std::uint32_t greatest = std::max({corners.x, corners.y, corners.z});
    if (greatest >= mesh.positions.size()) {
      throw DamagedMesh(fmt::format(
          "expected indices below {}, the number of vertices, found {} in triangle {} (both counted from 0)",
          mesh.positions.size(), greatest, t));
    }
  }
  return mesh;
}

Buffer<std::byte> content_of(const files::InputFile& file, MemoryUse& memory) {
  memory.take(file.size());
  Buffer<std::byte> content(file.size());
  if (auto read = file.read_at(0, content.span()); !read) throw DamagedMesh(read.error().message);
  return content;
}

FileSurface read_surface(const files::InputFile& file, const MeshReadOptions& options) {
  MemoryUse memory(file.context());
  const Buffer<std::byte> content = content_of(file, memory);
  const MeshSource source{file, content.span(), memory, options.normals, options.scene};
  return reader_of(source)(source);
}

// Returns the normals of `surface`, with an index for each triangle corner.
FileNormals normals_of(const FileSurface& surface) {
  FileNormals normals;
  const auto& [values, numbers] = surface.normals;
  if (values.empty()) return normals;
  if (numbers.empty() && values.size() != surface.positions.size()) {
    throw DamagedMesh(fmt::format("expected a normal for each of {} vertices, found {} normals",
                                  surface.positions.size(), values.size()));
  }
  const auto& corners = numbers.empty() ? surface.triangles : numbers;
  normals.values = Buffer<glm::vec3>(values.size());
  std::copy(values.begin(), values.end(), normals.values.begin());
  normals.numbers = Buffer<glm::uvec3>(corners.size());
  std::copy(corners.begin(), corners.end(), normals.numbers.begin());
  for (const glm::uvec3& t : normals.numbers) {
    for (int c = 0; c < 3; ++c) {
      if (t[c] < values.size() || t[c] == FileNormals::kNone) continue;
      throw DamagedMesh(fmt::format(
          "expected normal indices below {}, the number of normals, found {} (counted from 0)", values.size(), t[c]));
    }
  }
  return normals;
}

std::vector<MeshPart> parts_of(const FileSurface& surface, bool as_scene) {
  std::vector<MeshPart> parts;
  if (surface.parts.size() < 2 && !as_scene) return parts;
  for (std::size_t i = 0; i < surface.parts.size(); ++i) {
    const FilePart& part = surface.parts[i];
    const bool last = i + 1 == surface.parts.size();
    const std::uint64_t end_vertex = last ? surface.positions.size() : surface.parts[i + 1].first_vertex;
    const std::uint64_t end_triangle = last ? surface.triangles.size() : surface.parts[i + 1].first_triangle;
    parts.push_back(
        {{part.first_vertex, end_vertex - part.first_vertex, part.first_triangle, end_triangle - part.first_triangle},
         part.name,
         part.material});
  }
  return parts;
}

MeshFile read_file(const files::InputFile& file, const MeshReadOptions& options) {
  const Context& context = file.context();
  const FileSurface surface = read_surface(file, options);
  if (surface.positions.empty() && !surface.triangles.empty()) {
    throw DamagedMesh("expected vertices, found triangles without vertices");
  }
  MeshFile result;
  result.mesh = mesh_of(surface, context);
  result.parts = parts_of(surface, options.scene);
  if (surface.has_normals) merge_normal_copies(result.mesh, result.parts, context);
  const std::uint64_t normal_bytes =
      surface.normals.values.empty()
          ? 0
          : surface.normals.values.size() * sizeof(glm::vec3) + surface.triangles.size() * sizeof(glm::uvec3);
  std::uint64_t part_bytes = 0;
  for (const FilePart& part : surface.parts) part_bytes += sizeof(MeshPart) + part.name.size();
  if (surface.parts.size() < 2) part_bytes = 0;
  auto memory = context.reserve(result.mesh.positions.size() * mesh::vertex_bytes(result.mesh) +
                                    result.mesh.triangles.size_bytes() + normal_bytes + part_bytes,
                                "its vertices and triangles");
  if (!memory) throw DamagedMesh(memory.error().message, memory.error().hint);
  result.mesh.memory = std::move(*memory);
  result.normals = normals_of(surface);
  const bool from_stdin = files::is_standard_input(file.path());
  result.mesh.name = from_stdin ? file.name() : file.path().filename().string();
  result.format = surface.format;
  result.y_up = surface.y_up;
  result.is_quantized = surface.is_quantized;
  result.is_by_isoextract = surface.is_by_isoextract;
  if (surface.is_by_isoextract)
    result.placement = surface.placement.substr(0, kMaxPlacement);  // isoextract never writes a longer one
  if (options.scene && !surface.left_out.empty()) {
    result.notes.push_back(
        {NoteId::data_left_out,
         fmt::format("{}: the reader leaves out {}; it keeps positions, triangles, names, colors and attributes",
                     file.name(), fmt::join(surface.left_out, ", "))});
  }
  for (const Note& note : surface.notes) result.notes.push_back(prefixed(file.name() + ": ", note));
  return result;
}

}  // namespace

Result<MeshFile> read_mesh(const std::filesystem::path& path, const Context& context, const MeshReadOptions& options) {
  const auto name = [&] { return files::input_label(path); };  // allocates, so it is called only on failure
  try {
    const auto file = TRY(files::InputFile::open(path, context));
    return read_file(file, options);
  } catch (const Cancelled& cancelled) {
    return tl::unexpected(cancelled.error);
  } catch (const DamagedMesh& damage) {
    const std::string_view text = damage.what();
    const bool named = text.starts_with(name());
    return fail(ErrorCode::input, named ? std::string(text) : fmt::format("{}: {}", name(), text), damage.hint);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(fmt::format("{}: not enough memory to read it", name())));
  } catch (const std::exception& error) {
    return fail(ErrorCode::input, fmt::format("{}: reading failed: {}", name(), error.what()));
  }
}

bool holds_mesh(const std::filesystem::path& path, const Context& context) {
  constexpr std::size_t kBeginning = 4096;
  const auto file = files::InputFile::open(path, context);
  if (!file) return false;
  std::string text(static_cast<std::size_t>(std::min<std::uint64_t>(file->size(), kBeginning)), '\0');
  if (!file->read_at(0, std::as_writable_bytes(std::span(text)))) return false;
  return reader_by_mark(text) != nullptr || reader_by_beginning(text, file->size()) != nullptr;
}

std::optional<MeshFormat> find_mesh_format(const std::filesystem::path& path, const Context& context) {
  constexpr std::size_t kBeginning = 1 << 16;  // more than the header of any PLY needs
  std::error_code none;
  if (std::filesystem::is_directory(path, none)) return std::nullopt;
  const auto by_extension = mesh_format_by_path(path);
  const auto file = files::InputFile::open(path, context);
  const auto bytes = file ? files::first_bytes(*file, kBeginning) : Result<std::vector<std::byte>>();
  if (!file || !bytes) return by_extension == MeshFormat::ply ? std::nullopt : by_extension;
  const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  const Reader marked = reader_by_mark(text);
  if (marked == read_glb) return by_extension == MeshFormat::gltf ? by_extension : MeshFormat::glb;
  if (marked == read_drc) return MeshFormat::drc;
  if (marked == nullptr && files::is_standard_input(path)) {
    const Reader reader = reader_by_beginning(text, file->size());
    const auto entry = std::ranges::find(kReaders, reader, &std::pair<MeshFormat, Reader>::second);
    return entry == kReaders.end() ? std::nullopt : std::optional(entry->first);
  }
  if (marked == nullptr) return by_extension == MeshFormat::ply ? std::nullopt : by_extension;
  TextScanner lines(text);
  while (lines.next_line()) {
    const std::string_view word = lines.word();
    if (word == "end_header") break;
    if (word != "element") continue;
    const std::string_view element = lines.word();
    if ((element == "face" || element == "tristrips") && lines.word() != "0") return MeshFormat::ply;
  }
  return std::nullopt;
}

bool is_written_by_isoextract(const std::filesystem::path& path, const Context& context) {
  constexpr std::size_t kBeginning = 4096;  // the JSON of one mesh is shorter than that
  const auto file = files::InputFile::open(path, context);
  if (!file) return false;
  const auto bytes = files::first_bytes(*file, kBeginning);
  if (!bytes) return false;
  const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  const std::string name = fmt::format("{} ", kProgram);
  for (std::size_t at = text.find(name); at != std::string_view::npos; at = text.find(name, at + 1)) {
    // The signature begins an STL header, an OBJ or PLY comment, or the value of "generator" in glTF JSON or Draco
    // metadata; in Draco metadata a length byte precedes it.
    const std::string_view before = text.substr(0, at);
    const std::string_view near = before.substr(before.size() - std::min<std::size_t>(before.size(), 16));
    const bool is_entry = near.find("generator") != std::string_view::npos;
    if (before.empty() || before == "# " || before.ends_with("\ncomment ") || is_entry) return true;
  }
  return false;
}

std::vector<std::string> external_buffer_names(const std::filesystem::path& gltf, const Context& context) {
  std::vector<std::string> names;
  try {
    const auto file = files::InputFile::open(gltf, context);
    if (!file) return names;
    MemoryUse memory(context);
    const Buffer<std::byte> content = content_of(*file, memory);
    JsonTree tree(parse_json(MeshSource{*file, content.span(), memory}.text(), memory));
    const nlohmann::json& model = tree.root();
    if (!model.is_object() || !model.contains("buffers")) return names;
    for (std::uint64_t i = 0; i < model["buffers"].size(); ++i) {
      const std::string_view uri = text_of(entry(model, "buffers", i), "uri");
      if (!uri.empty() && !uri.starts_with("data:")) names.push_back(decode_percent(uri));
    }
  } catch (const std::exception&) {  // it is no glTF, or too large to parse
    names.clear();
  } catch (const Cancelled&) {
    names.clear();
  }
  return names;
}

void MemoryUse::take(std::uint64_t bytes) {
  if (const auto going_on = context_.check(); !going_on) throw Cancelled{going_on.error()};
  used_ = checked_sum(used_, bytes).value_or(std::numeric_limits<std::uint64_t>::max());
  if (used_ <= reserved_) return;
  // Reserves more than is missing, to reserve less often, if the budget allows it.
  const std::string what = "its bytes, vertices and triangles";
  const std::uint64_t missing = used_ - reserved_;
  auto memory = context_.reserve(std::max(missing, reserved_ / 8), what);
  if (!memory) memory = context_.reserve(missing, what);
  if (!memory) throw DamagedMesh(memory.error().message, memory.error().hint);
  reserved_ += memory->bytes();
  parts_.push_back(std::move(*memory));
}

void require_vertex_count(std::uint64_t count) {
  if (count <= std::numeric_limits<std::uint32_t>::max()) return;
  throw DamagedMesh(
      fmt::format("expected at most {} vertices, found {}", std::numeric_limits<std::uint32_t>::max(), count));
}

std::vector<std::uint32_t> weld_corners(std::span<const glm::vec3> corners, FileSurface& surface, MemoryUse& memory) {
  const auto first = static_cast<std::uint32_t>(surface.positions.size());
  constexpr std::uint32_t kFree = std::numeric_limits<std::uint32_t>::max();
  const std::size_t table_size = std::bit_ceil(2 * corners.size() + 1);
  const std::uint64_t bytes = (table_size + 2 * corners.size()) * sizeof(std::uint32_t);
  memory.take(bytes);
  std::vector<std::uint32_t> table(table_size, kFree);
  // Adding 0 turns -0 into 0. Comparing bits makes a NaN equal to itself, so the search ends; mesh_of() refuses NaN
  // later.
  const auto bits_of = [](const glm::vec3& p) {
    return glm::u64vec3(std::bit_cast<std::uint32_t>(p.x + 0.0F), std::bit_cast<std::uint32_t>(p.y + 0.0F),
                        std::bit_cast<std::uint32_t>(p.z + 0.0F));
  };
  std::vector<std::uint32_t> vertex_of(corners.size());
  std::vector<std::uint32_t> first_corner;
  first_corner.reserve(corners.size());
  for (std::size_t c = 0; c < corners.size(); ++c) {
    const glm::u64vec3 bits = bits_of(corners[c]);
    std::size_t place = hash_coordinates(bits.x, bits.y, bits.z) & (table.size() - 1);
    while (table[place] != kFree && bits_of(corners[first_corner[table[place]]]) != bits) {
      place = (place + 1) & (table.size() - 1);
    }
    if (table[place] == kFree) {
      table[place] = static_cast<std::uint32_t>(first_corner.size());
      first_corner.push_back(static_cast<std::uint32_t>(c));
    }
    vertex_of[c] = first + table[place];
  }
  memory.make_room(surface.positions, first_corner.size());
  memory.make_room(surface.triangles, corners.size() / 3);
  for (const std::uint32_t c : first_corner) surface.positions.emplace_back(corners[c]);
  for (std::size_t c = 0; c + 2 < corners.size(); c += 3) {
    surface.triangles.emplace_back(vertex_of[c], vertex_of[c + 1], vertex_of[c + 2]);
  }
  memory.give_back(bytes);
  return first_corner;
}

void add_polygon(std::vector<glm::uvec3>& triangles, std::span<const std::uint32_t> corners, MemoryUse& memory) {
  constexpr std::size_t kMostOfAFan = 16;
  memory.make_room(triangles, corners.size() - 2);
  if (corners.size() <= kMostOfAFan) {
    for (std::size_t i = 2; i < corners.size(); ++i) triangles.emplace_back(corners[0], corners[i - 1], corners[i]);
    return;
  }
  // Splits the part beyond the diagonal from `first` to `last` into a triangle and the parts beyond its two other
  // sides.
  const auto halve = [&](const auto& self, std::size_t first, std::size_t last) -> void {
    if (last - first < 2) return;
    const std::size_t middle = first + (last - first) / 2;
    triangles.emplace_back(corners[first], corners[middle], corners[last]);
    self(self, first, middle);
    self(self, middle, last);
  };
  halve(halve, 0, corners.size() - 1);
}

std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  return text.starts_with(kMark) ? text.substr(kMark.size()) : text;
}

bool TextScanner::next_line() {
  joins_next_ = false;
  if (rest_.empty()) return false;
  const auto ends = [&](char c) { return line_end_ ? c == *line_end_ : c == '\n' || c == '\r'; };
  std::size_t end = 0;
  while (end < rest_.size() && !ends(rest_[end])) ++end;
  line_ = rest_.substr(0, end);
  const std::size_t length = !line_end_ && rest_.substr(end).starts_with("\r\n") ? 2 : 1;
  rest_.remove_prefix(std::min(end + length, rest_.size()));
  ++line_number_;
  return true;
}

std::string_view TextScanner::word() {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; };
  std::size_t first = 0;
  while (first < line_.size() && is_blank(line_[first])) ++first;
  std::size_t last = first;
  while (last < line_.size() && !is_blank(line_[last])) ++last;
  const std::string_view found = line_.substr(first, last - first);
  line_.remove_prefix(last);
  return found;
}

std::string_view TextScanner::next_continued_word() {
  for (;;) {
    std::string_view found = word();
    if (found.ends_with('\\') && line_.find_first_not_of(" \t\r\v\f") == std::string_view::npos) {
      found.remove_suffix(1);
      joins_next_ = true;
    }
    if (!found.empty() || !joins_next_ || !next_line()) return found;
  }
}

std::string_view TextScanner::next_word_across_lines() {
  for (;;) {
    const std::string_view found = word();
    if (!found.empty() || !next_line()) return found;
  }
}

void TextScanner::expected(std::string_view what, std::string_view found) const {
  throw DamagedMesh(fmt::format("line {}: expected {}, found {}", line_number_, what,
                                found.empty() ? "nothing" : fmt::format("'{}'", files::printable(found, 40))));
}

double TextScanner::number(std::string_view word) const {
  const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
  double value = 0;
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (end != digits.data() + digits.size() || status == std::errc::invalid_argument) expected("a number", word);
  // from_chars does not tell overflow from underflow; strtod does.
  return status == std::errc::result_out_of_range ? std::strtod(std::string(digits).c_str(), nullptr) : value;
}

std::int64_t TextScanner::whole_number(std::string_view word) const {
  std::int64_t value = 0;
  const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (status != std::errc{} || end != word.data() + word.size()) expected("a whole number", word);
  return value;
}

}  // namespace isoextract::mesh_io
