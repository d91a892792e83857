// Text of simplification settings, in the form of the command line, and the simplification of labels.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "base/error.hpp"
#include "convert/events.hpp"
#include "convert/stages/surface_stages.hpp"
#include "convert/surface_edits.hpp"

namespace isoextract::convert {

// Returns the target number for a mesh of this many triangles: at least 1, at most all.
[[nodiscard]] std::uint64_t wanted_triangles(const TriangleCount& count, std::uint64_t triangles);
// Returns "100000" or "2.5%".
[[nodiscard]] std::string triangle_count_text(const TriangleCount& count);
// Returns "0.1voxel" or "0.5world".
[[nodiscard]] std::string simplify_bound_text(const SimplifyBound& bound);

// A label's surface that waits for its simplification, and the receiver of its report.
struct HeldLabel {
  Surface* surface;
  Events* events;
};

// Simplifies the surfaces of labels together (edit/label_net.hpp), as the job asks. A target number of triangles is for
// all labels together; a triangle that two labels share counts once. Each label gets a report, with time in proportion
// to its triangles. The first report has the sentences and notes about all labels. Fails as edit::LabelNet does.
[[nodiscard]] Result<void> simplify_labels(std::span<const HeldLabel> labels, const StageContext& stage);

}  // namespace isoextract::convert
