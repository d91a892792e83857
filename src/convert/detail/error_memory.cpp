#include "convert/detail/error_memory.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "accuracy/field_error.hpp"
#include "base/byte_size.hpp"
#include "convert/detail/partwise_output.hpp"
#include "field/surface_estimate.hpp"

namespace isoextract::convert {

Result<void> check_error_memory(const ConversionJob& job, const Source& source, const Context& context) {
  if (!job.error || source.empty) return {};
  // Closed surfaces have about twice as many triangles as vertices, surfaces of many small components fewer.
  const auto triangles_of = [](std::uint64_t vertices) { return vertices * 3 / 2; };
  const bool as_extracted = extract::method_info(job.surface.method).traits.follows_interpolant &&
                            !job.edits.simplify && !job.edits.pieces.drops() && source.clip.empty();
  for (const ResolvedIso& iso : source.isos) {
    if (iso.asked.is_label()) continue;
    const field::ScalarField& data = source.data ? *source.data : source.field;
    const std::uint64_t vertices = field::min_vertex_count(source.field, iso.id.iso(), source.region);
    std::uint64_t surface = vertices;
    if (source.data) surface = source.region ? 0 : field::min_vertex_count(data, iso.id.iso(), std::nullopt);
    std::uint64_t bytes =
        accuracy::field_error_memory(data, as_extracted ? triangles_of(vertices) : 0, triangles_of(surface)).least;
    if (as_extracted) {
      // Of a mesh that goes to its file by parts, the measurement extracts a window again.
      const bool is_whole = !goes_by_parts(job, source, iso.id.iso());
      const std::uint64_t held = is_whole ? vertices : std::min(vertices, accuracy::kWindowTriangles / 4);
      bytes += held * sizeof(glm::vec3) + triangles_of(held) * sizeof(glm::uvec3);
    }
    // Not MemoryBudget::left(): other conversions of a batch may give their memory back before this one needs it.
    const std::uint64_t limit = context.memory().limit();
    const std::uint64_t used = std::min(limit, context.memory().reserved());
    if (bytes <= limit - used) continue;
    return fail(
        ErrorCode::out_of_memory,
        fmt::format("{}: the surface at iso {} and the measurement of its error need at least {}; the limit is {}, "
                    "of which {} are in use",
                    source.label, iso.id.iso(), format_byte_size(bytes), format_byte_size(limit),
                    format_byte_size(used)),
        {Remedy::raise, Setting::memory_limit});
  }
  return {};
}

std::uint64_t estimated_error_bytes(const Source& source, double iso) {
  const std::uint64_t triangles = 2 * field::estimate_surface(source.field, iso).vertices;
  const field::ScalarField& data = source.data ? *source.data : source.field;
  const std::uint64_t of_data = source.data ? 2 * field::estimate_surface(data, iso).vertices : triangles;
  return accuracy::field_error_memory(data, triangles, of_data).usual;
}

}  // namespace isoextract::convert
