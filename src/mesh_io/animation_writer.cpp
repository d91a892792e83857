#include "mesh_io/animation_writer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "mesh_io/write/animated_glb.hpp"
#include "mesh_io/write/attempt.hpp"
#include "mesh_io/write/coordinate_rounding.hpp"
#include "mesh_io/write/gltf_packed_part.hpp"
#include "mesh_io/write/vertex_order.hpp"

namespace isoextract::mesh_io {
namespace {

// Returns the largest float32 that is not after `seconds`; infinity if `seconds` exceeds the range of float32.
float key_time(double seconds) {
  if (seconds > std::numeric_limits<float>::max()) return std::numeric_limits<float>::infinity();
  const auto nearest = static_cast<float>(seconds);
  const bool later = static_cast<double>(nearest) > seconds;
  return later ? std::nextafter(nearest, -std::numeric_limits<float>::infinity()) : nearest;
}

bool has_triangles(const mesh::Mesh& mesh) { return !mesh.triangles.empty(); }

// One file of the sequence and the range of frames in it.
struct AnimationPart {
  AnimatedGlb glb;
  std::int64_t first = 0;  // number of the first frame
  std::int64_t last = 0;
};

struct FrameSpan {
  std::int64_t first = 0;
  std::int64_t last = 0;
};

}  // namespace

std::filesystem::path path_of_animation_part(const std::filesystem::path& path, std::size_t part) {
  if (part <= 1) return path;
  std::filesystem::path name = path.stem();
  name += fmt::format(".part{}", part);
  name += path.extension();
  return path.parent_path() / name;
}

struct AnimationWriter::State {
  std::filesystem::path path;
  MeshWriteOptions options;
  double frames_per_second = 0;
  std::uint64_t expected_frames = 0;
  Context context;
  std::uint64_t largest_file = kLargestGlb;

  std::vector<AnimationPart> parts;   // empty until a frame is accepted
  std::optional<std::int64_t> first;  // number of the first accepted frame
  std::int64_t last = 0;
  std::optional<FrameSpan> span;
  std::map<std::int64_t, double> starts;  // seconds by frame; empty: times follow frame numbers
  std::uint64_t count = 0;                // number of frames added
  std::uint64_t collapsed = 0;            // triangles of all frames that rounding makes flat
  std::uint64_t triangles = 0;            // of all frames
  Notes notes;
  std::set<Note> told;  // copies of `notes`, for lookup
  std::vector<PackedFacts> packed;
  std::optional<Error> failure;

  [[nodiscard]] Result<void> check() const;
  // Returns the key time in seconds of the frame `later` (0 or 1) frames after `frame`.
  [[nodiscard]] float time_of(std::int64_t frame, int later = 0) const;
  [[nodiscard]] Result<void> check_frame(std::int64_t frame) const;
  // Returns why the frame was refused, or nullopt. Fails with errors that end the whole file.
  [[nodiscard]] Result<std::optional<Error>> add(const std::string& name, std::int64_t frame,
                                                 std::span<const mesh::Mesh> surfaces, const MeshPacking& packing,
                                                 const std::string& placement);
  // Makes parts that refer to the surfaces.
  [[nodiscard]] Result<std::vector<GltfPart>> pieces_of(std::span<const mesh::Mesh> surfaces,
                                                        const MeshPacking& packing, Notes& found) const;
  [[nodiscard]] Result<MeshWriteResult> finish();
  void tell(Notes more);
  void tell_of_parts();

  template <class Step>
  [[nodiscard]] std::invoke_result_t<Step> attempt(Step step) {
    auto done = mesh_io::attempt(failure, context, path, std::move(step));
    if (failure) parts.clear();  // removes their temporary files
    return done;
  }
};

Result<void> AnimationWriter::State::check() const {
  const auto unusable = [&](const std::string& found, const char* hint) {
    return fail(ErrorCode::usage, fmt::format("{}: {}", path.string(), found), hint);
  };
  if (options.format != MeshFormat::glb || options.ascii) {
    return fail(ErrorCode::usage,
                fmt::format("{}: expected {} for an animation, found {}{}", path.string(),
                            mesh_format_info(MeshFormat::glb).name, mesh_format_info(options.format).name,
                            options.ascii ? " as text" : ""),
                {Remedy::set, Setting::mesh_format, std::string(mesh_format_info(MeshFormat::glb).name)});
  }
  if (!std::isfinite(frames_per_second) || frames_per_second <= 0) {
    return unusable(fmt::format("expected a number of frames per second above 0, found {}", frames_per_second),
                    "give a number above 0, such as 24");
  }
  if (files::is_stream(path)) {
    return unusable("an animated glb cannot go to a stream: the writer completes the start of the file last",
                    "name a file");
  }
  return {};
}

float AnimationWriter::State::time_of(std::int64_t frame, int later) const {
  if (!starts.empty()) {
    const auto at = later == 0 ? starts.lower_bound(frame) : starts.upper_bound(frame);
    return key_time(at != starts.end() ? at->second : starts.rbegin()->second + 1 / frames_per_second);
  }
  const std::int64_t start = span ? span->first : first.value_or(frame);
  const std::uint64_t since = static_cast<std::uint64_t>(frame) - static_cast<std::uint64_t>(start);
  return key_time((static_cast<double>(since) + later) / frames_per_second);
}

Result<void> AnimationWriter::State::check_frame(std::int64_t frame) const {
  if (first && frame <= last) {
    return fail(ErrorCode::usage,
                fmt::format("{}: expected a frame number above {}, found {}", path.string(), last, frame));
  }
  const float time = time_of(frame);
  const bool is_later = !first || time > time_of(last);
  if (is_later && time < time_of(frame, 1) && std::isfinite(time_of(frame, 1))) return {};
  if (!starts.empty()) {
    return fail(ErrorCode::output,
                fmt::format("{}: frame {} is at {} seconds; float32 cannot separate it from a neighbor frame",
                            path.string(), frame, time),
                "the input states the time of each frame: give the frames times that are farther apart");
  }
  return fail(ErrorCode::output,
              fmt::format("{}: frame {} is at {} seconds; at {} frames per second, float32 cannot separate it from a "
                          "neighbor frame",
                          path.string(), frame, time, frames_per_second),
              {"number the frames consecutively", {Remedy::set, Setting::frame_rate, "24 or another usual rate"}});
}

Result<std::vector<GltfPart>> AnimationWriter::State::pieces_of(std::span<const mesh::Mesh> surfaces,
                                                                const MeshPacking& packing, Notes& found) const {
  MeshWriteOptions with = options;
  with.packing = packing;
  std::vector<GltfPart> pieces;
  if (packing.quantizes() && !packing.box && std::any_of(surfaces.begin(), surfaces.end(), has_triangles)) {
    return fail(ErrorCode::usage,
                fmt::format("{}: expected a bounding box for quantized positions, found none", path.string()));
  }
  for (const mesh::Mesh& surface : surfaces) {
    auto piece = GltfPart::make(surface, with, context, found);
    if (!piece) {
      piece.error().message = fmt::format("{}: {}", path.string(), piece.error().message);
      return tl::unexpected(std::move(piece.error()));
    }
    pieces.push_back(std::move(*piece));
  }
  return pieces;
}

Result<std::optional<Error>> AnimationWriter::State::add(const std::string& name, std::int64_t frame,
                                                         std::span<const mesh::Mesh> surfaces,
                                                         const MeshPacking& packing, const std::string& placement) {
  TRY(check());
  if (auto possible = check_frame(frame); !possible) return std::move(possible.error());
  std::uint64_t collapsed_in_frame = 0;
  std::uint64_t triangles_in_frame = 0;
  for (const mesh::Mesh& surface : surfaces) {
    const auto found = check_coordinate_rounding(surface, path, options.format);
    if (!found) return found.error();
    collapsed_in_frame += *found;
    triangles_in_frame += surface.triangles.size();
  }
  std::vector<mesh::Mesh> ordered;
  std::vector<Reservation> copies;
  if (packing.optimize_order) {
    for (const mesh::Mesh& surface : surfaces) {
      auto memory = context.reserve(
          surface.positions.size() * std::uint64_t{mesh::vertex_bytes(surface)} + surface.triangles.size_bytes(),
          "a copy of the mesh in another order");
      if (!memory) return std::move(memory.error());
      copies.push_back(std::move(*memory));
      if (auto done = optimize_order(ordered.emplace_back(mesh::copy(surface)), context); !done) {
        return std::move(done.error());
      }
    }
    surfaces = ordered;
  }
  Notes found;
  const auto pieces = pieces_of(surfaces, packing, found);
  if (!pieces) return pieces.error();
  if (!first) {
    parts.push_back({AnimatedGlb(path, largest_file, placement), frame, frame});
    TRY(parts.back().glb.open());
  }
  // Called only once the frame is accepted.
  const auto take = [&] {
    if (!first) {
      first = frame;
      options.placement = placement;
    }
    last = frame;
    parts.back().last = frame;
    collapsed += collapsed_in_frame;
    triangles += triangles_in_frame;
    ++count;
  };
  const float time = time_of(frame);
  if (std::none_of(surfaces.begin(), surfaces.end(), has_triangles)) {
    parts.back().glb.hide_all(time);
    take();
    return std::nullopt;
  }

  const std::uint64_t to_come = expected_frames > count ? expected_frames - count : 1;
  auto added = parts.back().glb.add(name, *pieces, time, to_come);
  if (added && !*added && first) {
    AnimatedGlb next(path_of_animation_part(path, parts.size() + 1), largest_file, options.placement);
    added = next.add(name, *pieces, time, to_come);
    if (added && *added) {
      parts.back().glb.hide_all(time);
      parts.push_back({std::move(next), frame, frame});
    }
  }
  if (!added) return tl::unexpected(std::move(added.error()));
  if (!*added) {
    if (!first) parts.clear();  // the first accepted frame gives the file its placement
    return Error{ErrorCode::output,
                 fmt::format("{}: frame {} does not fit into a file of {} bytes", path.string(), frame, largest_file),
                 "write each frame to a file of its own"};
  }
  take();
  for (const GltfPart& piece : *pieces) {
    if (piece.packed != nullptr)
      packed.push_back(piece.packed->facts);
    else if (packing.packs())
      packed.emplace_back();
  }
  if (placement != options.placement) {
    tell({{NoteId::placement_differs,
           "the frames have different placements; the file stores the placement of the first frame"}});
  }
  tell(std::move(found));
  tell(parts.back().glb.release_notes());
  return std::nullopt;
}

// Adds each different note once: most notes apply to every frame.
void AnimationWriter::State::tell(Notes more) {
  for (Note& note : more) {
    if (told.insert(note).second) notes.push_back(std::move(note));
  }
}

void AnimationWriter::State::tell_of_parts() {
  if (parts.size() > 1) {
    std::vector<std::string> where;
    for (const AnimationPart& part : parts) {
      where.push_back(fmt::format("{} to {} in {}", part.first, part.last, part.glb.path().filename().string()));
    }
    tell({{NoteId::several_files, fmt::format("a .glb holds at most {} bytes, so the writer splits the sequence: "
                                              "frames {}; each file keeps the time line of the whole sequence",
                                              largest_file, fmt::join(where, ", "))}});
  }
  const auto next = path_of_animation_part(path, parts.size() + 1);
  std::error_code ignored;
  if (std::filesystem::exists(next, ignored)) {
    tell({{NoteId::other_files, fmt::format("{} existed before and is not part of this sequence", next.string())}});
  }
}

Result<MeshWriteResult> AnimationWriter::State::finish() {
  TRY(check());
  if (!first) {
    return fail(ErrorCode::output,
                fmt::format("{}: expected at least one frame for an animation, found none", path.string()));
  }
  const float end = time_of(span ? std::max(last, span->last) : last, 1);
  std::vector<files::OutputFile*> files;
  MeshWriteResult result;
  for (AnimationPart& part : parts) {
    TRY(context.check());
    TRY(part.glb.finish(end));
    result.files.push_back({part.glb.path().string(), part.glb.file().bytes_written()});
    files.push_back(&part.glb.file());
  }
  if (collapsed > 0) tell({rounding_note(path, collapsed, triangles)});
  tell_of_parts();
  std::reverse(files.begin(), files.end());
  TRY(files::OutputFile::commit_all(files));
  result.notes = std::move(notes);
  return result;
}

AnimationWriter::AnimationWriter(const std::filesystem::path& path, const MeshWriteOptions& options,
                                 double frames_per_second, std::uint64_t expected_frames, const Context& context,
                                 std::uint64_t largest_file)
    : state_(std::make_unique<State>()) {
  state_->path = path;
  state_->options = options;
  state_->frames_per_second = frames_per_second;
  state_->expected_frames = expected_frames;
  state_->context = context;
  state_->largest_file = largest_file;
}

AnimationWriter::AnimationWriter(AnimationWriter&&) noexcept = default;
AnimationWriter& AnimationWriter::operator=(AnimationWriter&&) noexcept = default;
AnimationWriter::~AnimationWriter() = default;

void AnimationWriter::set_starts(std::span<const std::int64_t> frames, std::span<const double> starts) {
  for (std::size_t i = 0; i < frames.size(); ++i) state_->starts.emplace(frames[i], starts[i]);
}

void AnimationWriter::set_span(std::int64_t first, std::int64_t last) { state_->span = FrameSpan{first, last}; }

Result<void> AnimationWriter::check() const { return state_->check(); }

Result<void> AnimationWriter::check_times(std::span<const std::int64_t> frames) const {
  State trial;
  trial.path = state_->path;
  trial.frames_per_second = state_->frames_per_second;
  trial.starts = state_->starts;
  for (const std::int64_t frame : frames) {
    if (auto possible = trial.check_frame(frame); !possible) {
      possible.error().code = ErrorCode::usage;
      return possible;
    }
    if (!trial.first) trial.first = frame;
    trial.last = frame;
  }
  return {};
}

Result<void> AnimationWriter::add(const std::string& name, std::int64_t frame, std::span<const mesh::Mesh> surfaces,
                                  const MeshPacking& packing, const std::string& placement) {
  State& state = *state_;
  state.packed.clear();
  auto added = TRY(state.attempt([&] { return state.add(name, frame, surfaces, packing, placement); }));
  if (added) return tl::unexpected(std::move(*added));
  return {};
}

Result<void> AnimationWriter::add(const std::string& name, std::int64_t frame, const mesh::Mesh& surface) {
  return add(name, frame, std::span(&surface, 1));
}

std::span<const PackedFacts> AnimationWriter::packed() const { return state_->packed; }

bool AnimationWriter::has_failed() const { return state_->failure.has_value(); }

Result<MeshWriteResult> AnimationWriter::finish() {
  return state_->attempt([&] { return state_->finish(); });
}

}  // namespace isoextract::mesh_io
