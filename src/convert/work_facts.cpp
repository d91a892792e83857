#include "convert/work_facts.hpp"

#include <fmt/format.h>

#include "base/byte_size.hpp"
#include "base/printable.hpp"
#include "convert/json_values.hpp"
#include "convert/stages/surface_stages.hpp"

namespace isoextract::convert {
namespace {

WorkFact bricks_left_out(const extract::ExtractStats& stats, bool is_label) {
  const std::uint64_t count = stats.bricks - stats.bricks_visited;
  const double percent =
      stats.bricks == 0 ? 0.0 : 100.0 * static_cast<double>(count) / static_cast<double>(stats.bricks);
  return {WorkTopic::bricks, WorkDone::left_out, count, stats.bricks,
          fmt::format("{} of {} bricks ({}), which {} ({:.1f} %)", count, stats.bricks, stats.brick,
                      is_label ? "have no sample of the label" : "the iso value does not cross", percent)};
}

std::string dense_text(const field::DenseSamples& samples) {
  return fmt::format("{} x {} x {} samples of {}", samples.dims.x, samples.dims.y, samples.dims.z,
                     field::sample_type_name(samples.type));
}

}  // namespace

Json json_of(const WorkFact& fact) {
  Json json{{"what", word_of(fact.what)}, {"done", word_of(fact.done)}};
  if (fact.count) json["count"] = *fact.count;
  if (fact.total) json["total"] = *fact.total;
  json["text"] = fact.text;
  return json;
}

std::vector<WorkFact> reading_facts(const field::ScalarField& field, std::size_t more_grids) {
  std::vector<WorkFact> facts;
  if (field.grids > 1 + more_grids) {
    const std::uint64_t others = field.grids - 1 - more_grids;
    facts.push_back({WorkTopic::grids, WorkDone::left_out, others, field.grids,
                     fmt::format("the other {} grids of the file", others)});
  }
  if (field.parts.of > 0) {
    const std::uint64_t unread = field.parts.of - std::min(field.parts.read, field.parts.of);
    facts.push_back({WorkTopic::file_parts, WorkDone::left_out, unread, field.parts.of,
                     fmt::format("{} of {} parts of the file (chunks, slices or files)", unread, field.parts.of)});
  }
  const auto* dense = std::get_if<field::DenseSamples>(&field.samples);
  if (dense != nullptr && (dense->file_backed || dense->layers != nullptr)) {
    const std::uint64_t bytes = dense->count() * field::sample_size(dense->type);
    facts.push_back(
        {WorkTopic::samples, WorkDone::mapped, dense->count(), dense->count(),
         fmt::format("{} samples, {}, {}", dense->count(), format_byte_size(bytes),
                     dense->layers != nullptr ? "a few layers at a time" : "without a copy of the file in memory")});
  }
  return facts;
}

WorkFact attribute_fact(const VolumeAttribute& attribute) {
  const field::ScalarField& first = attribute.components.front();
  const auto* dense = std::get_if<field::DenseSamples>(&first.samples);
  return {WorkTopic::attributes, WorkDone::read, attribute.components.size(), std::nullopt,
          fmt::format("the attribute '{}' from {}: {}{}", printable(attribute.choice.name), first.name,
                      attribute.components.size() > 1 ? fmt::format("{} times ", attribute.components.size()) : "",
                      dense != nullptr ? dense_text(*dense)
                                       : fmt::format("sparse samples of {}", field::sample_type_name(first.type())))};
}

WorkFact choice_fact(const ParticleCount& count, const ParticleOptions& options) {
  std::string by = options.select ? fmt::format(" by the condition '{}'", printable(*options.select, 200)) : "";
  if (options.stride > 1) by += fmt::format("{} one of every {}", by.empty() ? "," : " and", options.stride);
  return {WorkTopic::particles_not_chosen, WorkDone::left_out, count.of - count.chosen, count.of,
          fmt::format("{} of {} particles; {} of {} particles chosen{}", count.of - count.chosen, count.of,
                      count.chosen, count.of, by)};
}

WorkFact region_fact(const ParticleCount& count) {
  const std::uint64_t removed = count.of - count.chosen;
  return {
      WorkTopic::particles_outside_region, WorkDone::left_out, removed, count.of,
      fmt::format("{} of {} particles, so far outside the region that it does not depend on them", removed, count.of)};
}

std::vector<WorkFact> particle_facts(const points::ParticleFieldStatistics& figures) {
  std::vector<WorkFact> facts;
  const std::uint64_t all = figures.particles + figures.particles_dropped + figures.particles_too_small;
  const std::string radius = !figures.radius_attribute.empty() ? ", the median of their radii"
                             : figures.radius_suggested        ? ", which fits their density"
                                                               : "";
  facts.push_back({WorkTopic::particles, WorkDone::made_into_a_field, figures.particles, all,
                   fmt::format("{} particles of radius {:.6g}{}, with samples {:.6g} apart in {} bricks (8x8x8)",
                               figures.particles, figures.radius, radius, figures.spacing, figures.bricks_stored)});
  if (figures.particles_dropped > 0) {
    facts.push_back(
        {WorkTopic::particles_not_finite, WorkDone::left_out, figures.particles_dropped, all,
         fmt::format("{} of {} particles, whose positions are not finite", figures.particles_dropped, all)});
  }
  if (figures.particles_too_small > 0) {
    facts.push_back({WorkTopic::particles_too_small, WorkDone::left_out, figures.particles_too_small, all,
                     fmt::format("{} of {} particles, whose radius is below {} sample spacings",
                                 figures.particles_too_small, all, figures.least_radius)});
  }
  if (figures.inside_tiles > 0 || figures.particles_deep_inside > 0) {
    facts.push_back({WorkTopic::particles_inside, WorkDone::left_out, figures.particles_deep_inside, figures.particles,
                     fmt::format("{} of {} particles, deep inside the surface; {} bricks, wholly inside",
                                 figures.particles_deep_inside, figures.particles, figures.inside_tiles)});
  }
  return facts;
}

WorkFact resolution_fact(const field::ScalarField& data, const field::ScalarField& grid) {
  const auto& made = std::get<field::DenseSamples>(grid.samples);
  const auto* dense = std::get_if<field::DenseSamples>(&data.samples);
  if (dense != nullptr && dense->data == made.data) {
    return {WorkTopic::resolution, WorkDone::left_out, std::nullopt, std::nullopt,
            "resampling, because the data has the requested resolution"};
  }
  const std::string before = dense != nullptr ? dense_text(*dense) : std::string("sparse samples");
  return {WorkTopic::resolution, WorkDone::resampled, made.count(), std::nullopt,
          fmt::format("{} to {}, {}", before, dense_text(made),
                      format_byte_size(made.count() * field::sample_size(made.type)))};
}

namespace {

std::vector<WorkFact> extraction_facts(const extract::ExtractStats& stats, const extract::ExtractOptions& options,
                                       const ConversionJob& job, bool is_label) {
  std::vector<WorkFact> facts;
  const bool is_terrain = job.surface.heights.has_value();
  if (!is_terrain) facts.push_back(bricks_left_out(stats, is_label));
  if (stats.places_visited > 0) {
    facts.push_back({WorkTopic::places, WorkDone::visited, stats.places_visited, std::nullopt,
                     fmt::format("{} brick positions next to stored bricks", stats.places_visited)});
  }
  if (!is_terrain && (!is_label || stats.samples_classified > 0)) {
    facts.push_back({WorkTopic::samples, WorkDone::compared, stats.samples_classified, std::nullopt,
                     fmt::format("{} samples, each once, with {}", stats.samples_classified,
                                 is_label ? "the labels" : "the iso value")});
  }
  if (stats.device) {
    const extract::DeviceStats& device = *stats.device;
    facts.push_back(
        {WorkTopic::uploads, WorkDone::uploaded, device.samples_uploaded, stats.samples_classified,
         fmt::format("{} of {} samples: bricks that the surface crosses, and the samples around these bricks",
                     device.samples_uploaded, stats.samples_classified)});
    if (const std::uint64_t bricks = device.bricks_uploaded + device.bricks_kept; bricks > 0) {
      facts.push_back({WorkTopic::resident, WorkDone::left_out, device.bricks_kept, bricks,
                       fmt::format("uploads of {} of {} bricks (8x8x8 samples), which the device has from an earlier "
                                   "extraction; {} bricks changed or are new",
                                   device.bricks_kept, bricks, device.bricks_uploaded)});
    }
    facts.push_back(
        {WorkTopic::decisions, WorkDone::taken_by_the_processor, device.cells_decided, std::nullopt,
         fmt::format("{} ambiguous cells, which need more precision than a shader has", device.cells_decided)});
  }
  if (stats.nan_samples > 0 && options.nan == extract::NanPolicy::hole) {
    facts.push_back({WorkTopic::nan_samples, WorkDone::left_as_holes, stats.nan_samples, std::nullopt,
                     fmt::format("{} samples that are not numbers", stats.nan_samples)});
    facts.push_back({WorkTopic::hole_cells, WorkDone::left_out, stats.hole_cells, std::nullopt,
                     fmt::format("{} cells that touch such a sample and the inside", stats.hole_cells)});
  } else if (stats.nan_samples > 0) {
    facts.push_back({WorkTopic::nan_samples, WorkDone::taken_as_outside, stats.nan_samples, std::nullopt,
                     fmt::format("{} samples that are not numbers", stats.nan_samples)});
  }
  if (options.region) {
    const glm::i64vec3 dims = options.region->dims();
    facts.push_back(
        {WorkTopic::roi, WorkDone::left_out, std::nullopt, std::nullopt,
         fmt::format("samples outside the region; the region has {} x {} x {} samples", dims.x, dims.y, dims.z)});
  }
  if (!options.smooth_normals && !are_per_triangle(job.normals)) {
    facts.push_back({WorkTopic::normals, WorkDone::left_out, std::nullopt, std::nullopt,
                     "normals, which the options do not request"});
  }
  if (!job.error) {
    facts.push_back({WorkTopic::error, WorkDone::left_out, std::nullopt, std::nullopt, "the error of the mesh"});
  }
  if (options.method == extract::Method::voxels && options.voxel_faces == extract::VoxelFaces::rectangles) {
    facts.push_back({WorkTopic::junction_vertices, WorkDone::left_out, std::nullopt, std::nullopt,
                     "vertices that would split the sides of rectangles where other rectangles meet them; these sides "
                     "are boundary edges"});
  }
  if (!options.cap && stats.inside_at_boundary) {
    facts.push_back({WorkTopic::caps, WorkDone::left_out, std::nullopt, std::nullopt,
                     stats.meets_boundary ? "caps where the surface reaches the data boundary"
                                          : "caps at the data boundary, all of which is inside"});
  }
  return facts;
}

// Returns the times of the steps before the mesh is made.
std::string counting_text(const extract::ExtractStats& stats) {
  if (!stats.counts_while_comparing) {
    return fmt::format("{:.3f} s to compare samples, {:.3f} s to count", stats.classify.wall_seconds,
                       stats.count.wall_seconds);
  }
  const std::string done =
      stats.early_vertices > 0 ? fmt::format(", count and make {} vertices", stats.early_vertices) : " and count";
  return fmt::format("{:.3f} s to compare samples{}", stats.count.wall_seconds, done);
}

}  // namespace

StageReport extraction_report(const extract::ExtractStats& stats, const extract::ExtractOptions& options,
                              const Surface& surface, const StageContext& stage, const StageTime& time) {
  StageReport report = stage.report_on(StageName::extract, surface);
  report.work = extraction_facts(stats, options, stage.job, surface.id.is_label());
  if (surface.taken) {
    report.work.push_back({WorkTopic::whole_mesh, WorkDone::left_out, std::nullopt, std::nullopt,
                           "the whole mesh in memory, because the program makes one part after the other"});
  }
  Figures figures;
  if (!surface.asked.is_number()) figures.emplace_back(Key::asked, text_of(surface.asked));
  figures.emplace_back(Key::triangles, surface.triangles());
  report.entries.push_back(std::move(figures));
  report.time = time;
  report.did = surface.taken ? "extracted and written" : "extracted";
  report.details.push_back(fmt::format("{}, {:.3f} s to make {}", counting_text(stats), stats.emit.wall_seconds,
                                       stats.early_vertices > 0 ? "the rest of the mesh" : "the mesh"));
  report.parts.push_back({StageName::classify, surface.id, stats.classify});
  if (const auto& device = stats.device) {
    report.parts.push_back({StageName::compile, surface.id, device->compile});
    report.parts.push_back({StageName::upload, surface.id, device->upload});
    report.details.push_back(fmt::format(
        "of that {:.3f} s to upload {}, {:.3f} s to capture {}, {:.3f} s to read it back, {:.3f} s to weld",
        device->upload.wall_seconds, format_byte_size(device->bytes_uploaded), device->capture.wall_seconds,
        format_byte_size(device->bytes_captured), device->read_back.wall_seconds, device->weld.wall_seconds));
  }
  report.parts.push_back({StageName::count, surface.id, stats.count});
  report.parts.push_back({StageName::emit, surface.id, stats.emit});
  return report;
}

}  // namespace isoextract::convert
