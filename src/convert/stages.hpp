// The stages of a conversion. A new surface edit needs a function here, a StageName, and a row of kStages at the same
// index. HTML pages and printed lines follow from the row; a section of the JSON report also needs a property in
// docs/schemas/report.schema.json.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::convert {

struct StageContext;
struct StageReport;
struct Surface;

enum class StageName {
  open,
  read,
  read_mesh,
  particles_to_field,
  choose_particles,
  read_attributes,
  filter,
  resample,
  statistics,
  place,
  classify,
  compile,
  upload,
  count,
  emit,
  extract,
  verify,
  repair,
  clip,
  attributes,
  pieces,
  relax,
  bodies,
  smooth,
  hollow,
  untangle,
  simplify,
  touching,
  require,
  color,
  normals,
  error,
  pack,
  mesh_facts,
  write,
};

// Edits or examines a surface, and returns a report. Does nothing and returns an empty report if the job does not ask
// for it. Fails as the algorithm that it calls does.
using EditSurface = Result<StageReport>(Surface& surface, const StageContext& context);
EditSurface repair_surface;  // of a mesh file, before it is clipped
EditSurface
    clip_surface;  // keeps what lies inside every half-space of Source::clip; with SurfaceOptions::cap, caps the cuts
EditSurface sample_vertex_attributes;  // runs before later stages drop components, or move or remove vertices
EditSurface drop_pieces;
EditSurface measure_relaxing;  // runs while all vertices are still where relaxing left them
EditSurface mark_bodies;       // assigns shells to bodies; runs before later stages may move one shell through another
EditSurface smooth_surface;
EditSurface hollow_surface;    // runs after smoothing, which would change the thickness of the wall
EditSurface untangle_surface;  // runs after smoothing, hollowing and the joint simplification of labels
EditSurface simplify_surface;
// Sets the mesh's material, colors the vertices by an attribute if the job asks for it, and then maps attributes to
// output coordinates. Runs when the vertices are final.
EditSurface color_surface;
EditSurface separate_touching;  // runs when no later stage moves vertices
EditSurface
    require_properties;  // fails with ErrorCode::verification if the mesh lacks a property of SurfaceEdits::require
// Runs after all edits that change the mesh: it duplicates vertices for their normals, which makes boundary edges
EditSurface shade_surface;
EditSurface measure_error;

struct StageInfo {
  StageName name = StageName::open;
  std::string_view word;  // name in the JSON report
  // Section of the JSON report with this stage's entries; empty: none.
  std::string_view section = {};
  // Returns whether the job asks for the stage; null: always. Reports list the sections of these stages; edits are
  // called in any case and check the job themselves.
  bool (*asked)(const ConversionJob& job) = nullptr;
  // The report lists the section even if `asked` returns false.
  bool is_listed = false;
  EditSurface* edit = nullptr;  // runs between the extraction of a surface and the writing of its file
  std::string_view done = {};   // past participle for printed lines: "smoothed"
  // Whether reports list the stage's time. False if other stages' times contain it, or if it contains their times.
  bool is_timed = true;
  int line_rank = 0;  // printed lines are sorted by rank: 0 first
};

// Stages in the order of StageName. Edits run and report sections appear in this order. Other stages may run elsewhere:
// `statistics` finds iso values right after `read`.
inline constexpr std::array kStages{
    StageInfo{StageName::open, "open"},
    StageInfo{StageName::read, "read"},
    StageInfo{.name = StageName::read_mesh,
              .word = "read mesh",
              .section = "mesh_files",
              .asked = [](const ConversionJob& job) { return job.source.mesh; }},
    StageInfo{StageName::particles_to_field, "particles to field"},
    StageInfo{.name = StageName::choose_particles,
              .word = "choose particles",
              .section = "particle_files",
              .asked = [](const ConversionJob& job) { return job.writes<ParticleFileOptions>() != nullptr; },
              .is_timed = false},
    StageInfo{StageName::read_attributes, "read attributes"},
    StageInfo{.name = StageName::filter, .word = "filter", .done = "filtered"},
    StageInfo{.name = StageName::resample, .word = "resample", .done = "resampled"},
    StageInfo{StageName::statistics, "statistics"},
    StageInfo{.name = StageName::place, .word = "place", .is_timed = false},
    StageInfo{StageName::classify, "classify"},
    StageInfo{StageName::compile, "compile"},
    StageInfo{StageName::upload, "upload"},
    StageInfo{StageName::count, "count"},
    StageInfo{StageName::emit, "emit"},
    StageInfo{.name = StageName::extract,
              .word = "extract",
              .section = "extractions",
              .done = "extracted",
              .is_timed = false},
    StageInfo{.name = StageName::verify,
              .word = "verify",
              .section = "verification",
              .asked = [](const ConversionJob& job) { return job.verify; },
              .line_rank = 4},
    StageInfo{.name = StageName::repair,
              .word = "repair",
              .section = "repairs",
              .asked = [](const ConversionJob& job) { return job.edits.repair.has_value(); },
              .line_rank = -1},
    StageInfo{.name = StageName::clip,
              .word = "clip",
              .asked = [](const ConversionJob& job) { return !job.source.clip.empty(); },
              .done = "clipped",
              .is_timed = false},
    StageInfo{.name = StageName::attributes,
              .word = "attributes",
              .section = "attributes",
              .asked = [](const ConversionJob& job) { return !job.source.attributes.empty(); },
              .edit = sample_vertex_attributes},
    StageInfo{.name = StageName::pieces,
              .word = "pieces",
              .section = "pieces",
              .asked = [](const ConversionJob& job) { return job.edits.pieces.drops(); },
              .edit = drop_pieces,
              .done = "components removed"},
    StageInfo{.name = StageName::relax,
              .word = "relax",
              .section = "relaxations",
              .asked = [](const ConversionJob& job) { return job.surface.relaxes(); },
              .edit = measure_relaxing,
              .is_timed = false},
    StageInfo{.name = StageName::bodies, .word = "bodies", .edit = mark_bodies, .is_timed = false},
    StageInfo{.name = StageName::smooth,
              .word = "smooth",
              .section = "smoothings",
              .asked = [](const ConversionJob& job) { return job.edits.smooth.has_value(); },
              .edit = smooth_surface,
              .done = "smoothed"},
    StageInfo{.name = StageName::hollow,
              .word = "hollow",
              .section = "hollows",
              .asked = [](const ConversionJob& job) { return job.edits.hollow.has_value(); },
              .edit = hollow_surface,
              .done = "hollowed"},
    StageInfo{.name = StageName::untangle,
              .word = "untangle",
              .section = "untanglings",
              .asked = [](const ConversionJob& job) { return job.edits.untangles(); },
              .edit = untangle_surface,
              .done = "untangled"},
    StageInfo{.name = StageName::simplify,
              .word = "simplify",
              .section = "simplifications",
              .asked = [](const ConversionJob& job) { return job.edits.simplify.has_value(); },
              .is_listed = true,
              .edit = simplify_surface,
              .done = "simplified"},
    StageInfo{.name = StageName::touching,
              .word = "touching",
              .section = "touching",
              .asked = [](const ConversionJob& job) { return job.edits.touching == Touching::apart; },
              .edit = separate_touching},
    StageInfo{.name = StageName::require, .word = "require", .edit = require_properties, .is_timed = false},
    StageInfo{.name = StageName::color,
              .word = "color",
              .section = "colors",
              .asked = [](const ConversionJob& job) { return job.color && job.color->attribute; },
              .edit = color_surface,
              .is_timed = false,
              .line_rank = 1},
    StageInfo{.name = StageName::normals, .word = "normals", .edit = shade_surface},
    StageInfo{.name = StageName::error, .word = "error", .edit = measure_error, .line_rank = 3},
    StageInfo{.name = StageName::pack,
              .word = "pack",
              .section = "packings",
              .asked = [](const ConversionJob& job) { return job.meshes().packing.packs(); },
              .is_timed = false,
              .line_rank = 2},
    StageInfo{.name = StageName::mesh_facts, .word = "mesh facts", .section = "meshes"},
    StageInfo{StageName::write, "write"},
};

[[nodiscard]] constexpr const StageInfo& stage_info(StageName name) { return kStages[static_cast<std::size_t>(name)]; }

constexpr auto words_of(StageName /*type*/) {
  std::array<Word<StageName>, kStages.size()> words{};
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = {kStages[i].name, kStages[i].word};
  return words;
}

}  // namespace isoextract::convert
