// NRRD. teem parses the header's fields; sample_source.cpp reads the samples, raw or gzip. teem itself would open the
// data files that a header names, wherever they are, before their paths could be checked.
#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <teem/nrrd.h>

#include "base/ascii.hpp"
#include "base/checked.hpp"
#include "base/printable.hpp"
#include "files/file_start.hpp"
#include "volume_io/detail/dense_format.hpp"
#include "volume_io/detail/formats.hpp"
#include "volume_io/formats/nrrd_header.hpp"
#include "volume_io/formats/nrrd_segments.hpp"

namespace isoextract::volume_io {
namespace {

constexpr std::string_view kNrrdMagic = "NRRD00";
constexpr const char* kSpacingAssumed = "the header has no spacings or directions: the reader assumes a spacing of 1";

struct NrrdDeleter {
  void operator()(Nrrd* nrrd) const { ::nrrdNuke(nrrd); }
  void operator()(NrrdIoState* state) const { ::nrrdIoStateNix(state); }
};

// A header as parsed by teem.
struct ParsedNrrd {
  std::unique_ptr<Nrrd, NrrdDeleter> nrrd;
  std::unique_ptr<NrrdIoState, NrrdDeleter> state;

  [[nodiscard]] bool has(int field) const { return state->seen[field] != 0; }
};

// Guards teem's error messages, which are global variables.
std::mutex& teem_mutex() {
  static std::mutex mutex;
  return mutex;
}

// Returns the last line of teem's messages, the innermost error, without function names.
std::string innermost_message(std::string messages) {
  while (messages.ends_with('\n')) messages.pop_back();
  messages.erase(0, messages.rfind('\n') + 1);
  const std::size_t names = messages.rfind("Parse_");
  const std::size_t colon = messages.find(": ", names == std::string::npos ? 0 : names);
  if (colon != std::string::npos) messages.erase(0, colon + 2);
  return printable(messages, 300);
}

Result<void> check_fields(const std::string& file, const ParsedNrrd& parsed) {
  for (const int field : {nrrdField_type, nrrdField_dimension, nrrdField_sizes, nrrdField_encoding}) {
    if (parsed.has(field)) continue;
    return fail(ErrorCode::input,
                fmt::format("{}: the header has no field '{}'", file, ::airEnumStr(nrrdField, field)));
  }
  return {};
}

Result<ParsedNrrd> parse_fields(const std::string& file, const std::string& fields) {
  const std::scoped_lock lock(teem_mutex());
  nrrdStateVerboseIO = 0;
  ParsedNrrd parsed{std::unique_ptr<Nrrd, NrrdDeleter>(::nrrdNew()),
                    std::unique_ptr<NrrdIoState, NrrdDeleter>(::nrrdIoStateNew())};
  if (!parsed.nrrd || !parsed.state) throw std::bad_alloc();
  parsed.state->skipData = AIR_TRUE;
  const bool failed = ::nrrdStringRead(parsed.nrrd.get(), fields.c_str(), parsed.state.get()) != 0;
  std::string messages;
  if (failed) {
    const std::unique_ptr<char, decltype(&std::free)> text(::biffGetDone(NRRD), &std::free);
    if (text) messages = text.get();
  }
  // Gives clearer messages than teem if every line is valid but a field is missing.
  if (!failed || messages.find("complete valid header") != std::string::npos) {
    TRY(check_fields(file, parsed));
  }
  if (failed) {
    return fail(ErrorCode::input, fmt::format("{}: not a valid NRRD header: {}", file, innermost_message(messages)));
  }
  return parsed;
}

// Returns f64 for 64-bit integers, which are converted to double.
Result<field::SampleType> sample_type_of(const std::string& file, const Nrrd& nrrd) {
  switch (nrrd.type) {
    case nrrdTypeChar: return field::SampleType::i8;
    case nrrdTypeUChar: return field::SampleType::u8;
    case nrrdTypeShort: return field::SampleType::i16;
    case nrrdTypeUShort: return field::SampleType::u16;
    case nrrdTypeInt: return field::SampleType::i32;
    case nrrdTypeUInt: return field::SampleType::u32;
    case nrrdTypeFloat: return field::SampleType::f32;
    case nrrdTypeLLong:
    case nrrdTypeULLong:
    case nrrdTypeDouble: return field::SampleType::f64;
    default: break;
  }
  return fail(
      ErrorCode::input,
      fmt::format("{}: expected integers, float or double, found type '{}'", file, ::airEnumStr(nrrdType, nrrd.type)),
      "expand the blocks into numbers, for example with: unu unblock -t float -i IN.nrrd -o OUT.nrrd");
}

bool has_direction(const Nrrd& nrrd, unsigned axis) {
  return nrrd.spaceDim > 0 && std::isfinite(nrrd.axis[axis].spaceDirection[0]);
}

bool is_spatial_kind(int kind) { return kind == nrrdKindUnknown || kind == nrrdKindDomain || kind == nrrdKindSpace; }

// Returns whether an axis of this kind enumerates volumes instead of components.
bool is_series_kind(int kind) { return kind == nrrdKindTime || kind == nrrdKindList; }

struct NrrdAxes {
  std::array<unsigned, 3> space{};     // fastest first
  std::optional<unsigned> series;      // axis of several volumes; faster or slower than the spatial ones
  std::optional<unsigned> components;  // axis of several components; also faster or slower
};

// Finds the axes; ignores additional axes of length 1.
Result<NrrdAxes> find_axes(const std::string& file, const ParsedNrrd& parsed, Notes& notes) {
  const Nrrd& nrrd = *parsed.nrrd;
  const auto describe = [&](unsigned axis) {
    const int kind = nrrd.axis[axis].kind;
    return fmt::format("axis {} ({} values{})", axis, nrrd.axis[axis].size,
                       kind == nrrdKindUnknown ? "" : fmt::format(", kind {}", ::airEnumStr(nrrdKind, kind)));
  };
  std::vector<unsigned> kept;
  std::vector<unsigned> dropped;
  NrrdAxes axes;
  for (unsigned axis = 0; axis < nrrd.dim; ++axis) {
    const bool without_direction = nrrd.dim > 3 && parsed.has(nrrdField_space_directions) && !has_direction(nrrd, axis);
    const bool spatial = is_spatial_kind(nrrd.axis[axis].kind) && !without_direction;
    if (nrrd.axis[axis].size > 1 && is_series_kind(nrrd.axis[axis].kind) && !axes.series) {
      axes.series = axis;
      continue;
    }
    if (!spatial && nrrd.axis[axis].size > 1) {
      if (!axes.components && !is_series_kind(nrrd.axis[axis].kind)) {
        axes.components = axis;
        continue;
      }
      return fail(
          ErrorCode::input,
          fmt::format("{}: expected at most one axis of volumes and one of components, found {} as well", file,
                      describe(axis)),
          fmt::format(
              "select one value of that axis first, for example with: unu slice -a {} -p 0 -i IN.nrrd -o OUT.nrrd",
              axis));
    }
    (spatial ? kept : dropped).push_back(axis);
  }
  while (kept.size() > 3) {
    const auto last = std::find_if(kept.rbegin(), kept.rend(), [&](unsigned a) { return nrrd.axis[a].size == 1; });
    if (last == kept.rend()) break;
    dropped.push_back(*last);
    kept.erase(std::next(last).base());
  }
  if (kept.size() != 3) {
    return fail(ErrorCode::input, fmt::format("{}: expected three spatial axes, found {}", file, kept.size()));
  }
  for (const unsigned axis : dropped)
    notes.push_back({NoteId::axes_dropped, fmt::format("the reader drops axis {}, which has length 1", axis)});
  for (const auto& [axis, what] : {std::pair(axes.series, "volumes"), std::pair(axes.components, "components")}) {
    if (!axis || *axis < kept.front() || *axis > kept.back()) continue;
    return fail(ErrorCode::input,
                fmt::format("{}: expected the axis of the {} before or after the axes of space, found {} between them",
                            file, what, describe(*axis)),
                "put that axis first or last with: unu permute -p AXIS... -i IN.nrrd -o OUT.nrrd");
  }
  axes.space = {kept[0], kept[1], kept[2]};
  return axes;
}

// Returns the placement from direction vectors in a named space.
Frame oriented_frame(const ParsedNrrd& parsed, const std::array<unsigned, 3>& axes) {
  const Nrrd& nrrd = *parsed.nrrd;
  Frame frame;
  if (nrrd.spaceDim != 3) {
    frame.problem = fmt::format("expected a space of 3 dimensions, found {}", nrrd.spaceDim);
    return frame;
  }
  for (int i = 0; i < 3; ++i) {
    const unsigned axis = axes[static_cast<std::size_t>(i)];
    const double spacing = nrrd.axis[axis].spacing;
    if (has_direction(nrrd, axis)) {
      for (int row = 0; row < 3; ++row) frame.index_to_world.linear[i][row] = nrrd.axis[axis].spaceDirection[row];
    } else if (!parsed.has(nrrdField_space_directions) && std::isfinite(spacing)) {
      frame.index_to_world.linear[i][i] = spacing;
    } else if (!parsed.has(nrrdField_space_directions) && !parsed.has(nrrdField_spacings)) {
      if (i == 0) frame.assumed_axes.push_back({NoteId::placement_assumed, kSpacingAssumed});
    } else {
      frame.problem = fmt::format("axis {} has no direction in space", axis);
    }
  }
  if (std::isfinite(nrrd.spaceOrigin[0])) {
    frame.index_to_world.offset = {nrrd.spaceOrigin[0], nrrd.spaceOrigin[1], nrrd.spaceOrigin[2]};
  } else {
    frame.assumed_origin.push_back(
        {NoteId::placement_assumed, "the header has no space origin: the reader assumes 0,0,0"});
    frame.stated = parsed.has(nrrdField_space_directions) || parsed.has(nrrdField_spacings);
  }
  return frame;
}

// Returns the placement from spacings, mins and maxs per axis. A cell-centered axis starts half a spacing before its
// first sample. Cells are the default if the header does not specify the centering, as in teem.
Frame axis_aligned_frame(const ParsedNrrd& parsed, const std::array<unsigned, 3>& axes) {
  Frame frame;
  bool any_spacing = false;
  bool any_min = false;
  for (int i = 0; i < 3; ++i) {
    const NrrdAxisInfo& axis = parsed.nrrd->axis[axes[static_cast<std::size_t>(i)]];
    const bool node = axis.center == nrrdCenterNode;
    double spacing = axis.spacing;
    if (!std::isfinite(spacing) && std::isfinite(axis.min) && std::isfinite(axis.max)) {
      spacing = (axis.max - axis.min) / static_cast<double>(node ? axis.size - 1 : axis.size);
    }
    if (!std::isfinite(spacing)) {
      if (parsed.has(nrrdField_spacings)) {
        frame.problem = fmt::format("axis {} has no finite spacing", axes[static_cast<std::size_t>(i)]);
        return frame;
      }
      spacing = 1;
    } else {
      any_spacing = true;
    }
    frame.index_to_world.linear[i][i] = spacing;
    if (!std::isfinite(axis.min)) continue;
    any_min = true;
    frame.index_to_world.offset[i] = axis.min + (node ? 0 : spacing / 2);
  }
  frame.stated = any_spacing || any_min;
  if (!any_spacing) frame.assumed_axes.push_back({NoteId::placement_assumed, kSpacingAssumed});
  return frame;
}

// Returns the unit of the space, or of the axes if it has none. Lists all units if they differ.
std::string length_unit_of(const Nrrd& nrrd, const std::array<unsigned, 3>& axes) {
  std::array<std::string, 3> units;
  for (unsigned i = 0; i < 3; ++i) {
    const char* text = nrrd.spaceDim > i ? nrrd.spaceUnits[i] : nullptr;
    if (text == nullptr) text = nrrd.axis[axes[i]].units;
    if (text != nullptr) units[i] = trimmed(text);
  }
  if (units[0] == units[1] && units[1] == units[2]) return units[0];
  return fmt::format("{}", fmt::join(units, ", "));
}

// Fails if the number of data files does not match the slow axes of the volume.
Result<void> check_file_count(const std::string& file, const Nrrd& nrrd, const NrrdDataFiles& files) {
  const unsigned dimension = files.file_dimension.value_or(nrrd.dim - 1);
  const std::uint64_t found = files.count();
  const std::uint64_t slowest = nrrd.axis[nrrd.dim - 1].size;
  if (dimension == nrrd.dim && found > 0 && slowest % found == 0) return {};
  std::optional<std::uint64_t> expected = 1;
  for (unsigned axis = dimension; axis < nrrd.dim && expected; ++axis) {
    expected = checked_product(*expected, std::uint64_t{nrrd.axis[axis].size});
  }
  if (dimension >= 1 && dimension < nrrd.dim && expected == found) return {};
  if (dimension < 1 || dimension > nrrd.dim) {
    return fail(ErrorCode::input, fmt::format("{}: expected 1 to {} as the dimension of the data files (the last "
                                              "number of the field 'data file'), found {}",
                                              file, nrrd.dim, dimension));
  }
  if (dimension == nrrd.dim) {
    return fail(
        ErrorCode::input,
        fmt::format("{}: expected a number of data files that divides the {} slices of the slowest axis, found {}",
                    file, slowest, found));
  }
  return fail(
      ErrorCode::input,
      fmt::format("{}: expected {} data files, one for each index along the axes that the files do not contain, "
                  "found {}",
                  file, expected ? std::to_string(*expected) : "more than 2^64", found));
}

// Returns the offset after `lines` line ends.
Result<std::uint64_t> skip_lines(const files::InputFile& file, std::uint64_t offset, unsigned lines) {
  std::vector<char> block(std::size_t{64} << 10);
  while (lines > 0) {
    if (offset >= file.size())
      return fail(
          ErrorCode::input,
          file.name() + ": expected as many lines before the samples as 'line skip' says, found the end of the file");
    const auto part =
        std::span(block).first(static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), file.size() - offset)));
    TRY(file.read_at(offset, std::as_writable_bytes(part)));
    auto at = part.begin();
    while (lines > 0 && (at = std::find(at, part.end(), '\n')) != part.end()) {
      ++at;
      --lines;
    }
    offset += static_cast<std::uint64_t>(at - part.begin());
  }
  return offset;
}

// Returns where the samples start in a data file, from "line skip" and "byte skip".
Result<SamplePiece> locate_piece(const std::filesystem::path& path, std::uint64_t offset, const NrrdIoState& state,
                                 std::uint64_t piece_bytes, const Context& context) {
  const auto file = TRY(files::InputFile::open(path, context));
  const auto behind_lines = TRY(skip_lines(file, offset, state.lineSkip));
  SamplePiece piece{path, behind_lines};
  piece.gzip = state.encoding == nrrdEncodingGzip;
  if (state.byteSkip >= 0) {
    const auto skip = static_cast<std::uint64_t>(state.byteSkip);
    (piece.gzip ? piece.skip : piece.offset) += skip;
    return piece;
  }
  // -1: the samples are at the end of the file; -1 - n: n bytes follow them.
  const std::uint64_t behind = static_cast<std::uint64_t>(-(state.byteSkip + 1));
  const auto from_end = checked_sum(piece_bytes, behind);
  if (piece.gzip) {
    return fail(ErrorCode::input,
                fmt::format("{}: 'byte skip' {} needs encoding raw, found gzip", file.name(), state.byteSkip));
  }
  if (!from_end || *from_end > file.size()) {
    return fail(ErrorCode::input,
                fmt::format("{}: 'byte skip' {} needs a file of at least {} bytes, found {}", file.name(),
                            state.byteSkip, from_end ? std::to_string(*from_end) : "2^64", file.size()));
  }
  piece.offset = file.size() - *from_end;
  return piece;
}

Result<std::vector<SamplePiece>> locate_samples(const files::InputFile& file, const NrrdHeaderText& text,
                                                const ParsedNrrd& parsed, std::uint64_t bytes) {
  std::vector<SamplePiece> pieces;
  if (!text.detached) {
    auto piece = TRY(locate_piece(file.path(), text.data_offset, *parsed.state, bytes, file.context()));
    pieces.push_back(std::move(piece));
    return pieces;
  }
  if (text.detached->several) {
    TRY(check_file_count(file.name(), *parsed.nrrd, *text.detached));
  }
  // Resolves each name before generating the next, so a header cannot request more names than there are files.
  const std::uint64_t count = text.detached->count();
  for (std::uint64_t i = 0; i < count; ++i) {
    auto path = TRY(files::resolve_beside(file.path(), text.detached->name(i)));
    auto piece = TRY(locate_piece(path, 0, *parsed.state, bytes / count, file.context()));
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

Result<void> check_encoding(const std::string& file, const NrrdIoState& state) {
  if (state.encoding == nrrdEncodingRaw || state.encoding == nrrdEncodingGzip) return {};
  return fail(ErrorCode::input, fmt::format("{}: expected encoding raw or gzip, found {}", file, state.encoding->name),
              "rewrite it, for example with: unu save -f nrrd -e gzip -i IN.nrrd -o OUT.nrrd");
}

Result<DenseFile> open_nrrd(const files::InputFile& file) {
  const auto content = TRY(files::first_bytes(file, files::kStartBytes));
  if (!files::starts_with(content, kNrrdMagic)) return files::bad_signature_error(file, "a NRRD file", "'NRRD000'");
  const auto text = TRY(read_nrrd_header(file));
  const auto parsed = TRY(parse_fields(file.name(), text.fields));
  const Nrrd& nrrd = *parsed.nrrd;

  DenseFile dense;
  dense.format = "NRRD";
  const auto type = TRY(sample_type_of(file.name(), nrrd));
  dense.type = type;
  TRY(check_encoding(file.name(), *parsed.state));
  const auto found = TRY(find_axes(file.name(), parsed, dense.notes));
  const std::array<unsigned, 3>& axes = found.space;
  const auto dims =
      TRY(checked_dims(file.name(), {nrrd.axis[axes[0]].size, nrrd.axis[axes[1]].size, nrrd.axis[axes[2]].size}, type));
  dense.dims = dims;
  if (nrrd.type == nrrdTypeLLong) dense.wide = Integer64::i64;
  if (nrrd.type == nrrdTypeULLong) dense.wide = Integer64::u64;
  if (found.series) {
    dense.volumes = nrrd.axis[*found.series].size;
    dense.interleaved = *found.series < axes[0];
  }
  if (found.components) {
    dense.components = nrrd.axis[*found.components].size;
    dense.components_interleaved = *found.components < axes[0];
    dense.component_before_volume = found.series && *found.components < *found.series;
  }
  const std::uint64_t parts = checked_product(dense.volumes, dense.components).value_or(~std::uint64_t{0});
  TRY(check_volume_count(file.name(), dims, type, parts));
  dense.labels = TRY(parse_segments(file.name(), text.segments, dense.volumes));
  dense.endian = parsed.state->endian == airEndianBig ? std::endian::big : std::endian::little;
  if (nrrd.space != nrrdSpaceUnknown) dense.world_space = ::airEnumStr(nrrdSpace, nrrd.space);
  dense.length_unit = length_unit_of(nrrd, axes);
  dense.frame = nrrd.spaceDim > 0 ? oriented_frame(parsed, axes) : axis_aligned_frame(parsed, axes);
  dense.pieces = TRY(locate_samples(file, text, parsed, sample_bytes(dims, type) * parts));
  return dense;
}

class NrrdFormat final : public DenseFormat {
 public:
  NrrdFormat()
      : DenseFormat({.id = "nrrd",
                     .title = "NRRD, attached or detached, raw or gzip",
                     .extensions = {".nrrd", ".nhdr"},
                     .has_volumes = true,
                     .has_components = true,
                     .library = "teem"}) {}

  [[nodiscard]] bool probe(const files::FileStart& start) const override {
    return !start.packed && files::starts_with(start.bytes, kNrrdMagic);
  }

 protected:
  [[nodiscard]] Result<DenseFile> open_header(const files::InputFile& file,
                                              const ReadOptions& /*options*/) const override {
    return open_nrrd(file);
  }
};

}  // namespace

const VolumeFormat& nrrd_format() {
  static const NrrdFormat format;
  return format;
}

}  // namespace isoextract::volume_io
