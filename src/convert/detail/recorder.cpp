#include "convert/detail/recorder.hpp"

#include <algorithm>
#include <utility>

namespace isoextract::convert {

void Recorder::begin_grid(const std::optional<std::string>& grid) {
  again_ = std::ranges::find(begun_, grid) != begun_.end();
  if (!again_) begun_.push_back(grid);
}

void Recorder::note(const std::string& text) {
  if (again_) return;
  outcome_.notes.push_back(text);
  listener_.note(text);
}

void Recorder::opened(const extract::Extractor& extractor, const StageTime& time) {
  outcome_.backend = extractor.name();
  outcome_.device = extractor.device();
  if (outcome_.backend == word_of(Backend::gpu)) outcome_.stages.push_back({StageName::open, std::nullopt, time});
  listener_.opened(extractor, time);
}

void Recorder::read(const std::string& input, const field::ScalarField& field, const StageTime& time) {
  outcome_.stages.push_back({StageName::read, std::nullopt, time});
  if (!begun_.empty()) grid_ = field.grid.empty() ? field.name : field.grid;
  if (!again_ && outcome_.input) {
    outcome_.more_grids.push_back(input_facts(input, field));
  } else if (!again_) {
    outcome_.input = input_facts(input, field);
  }
  listener_.read(input, field, time);
}

void Recorder::made_field(const ParticleRecord& record) {
  outcome_.stages.push_back({StageName::particles_to_field, std::nullopt, record.time});
  outcome_.particles = record;
  listener_.made_field(record);
}

void Recorder::filtered(const WorkFact& fact, const StageTime& time) {
  outcome_.stages.push_back({StageName::filter, std::nullopt, time});
  if (again_) return;
  outcome_.work.push_back(fact);
  listener_.filtered(fact, time);
}

void Recorder::resolved(const std::vector<ResolvedIso>& isos, const std::optional<StageTime>& time) {
  if (time) outcome_.stages.push_back({StageName::statistics, std::nullopt, *time});
  if (again_) return;
  outcome_.isos.insert(outcome_.isos.end(), isos.begin(), isos.end());
  listener_.resolved(isos, time);
}

void Recorder::read_attributes(const StageTime& time) {
  outcome_.stages.push_back({StageName::read_attributes, std::nullopt, time});
  listener_.read_attributes(time);
}

void Recorder::lacked(const std::string& attribute) {
  // The same one may be asked for twice: as it is, and for colours.
  std::vector<std::string>& lacked = outcome_.lacked_attributes;
  if (std::ranges::find(lacked, attribute) == lacked.end()) lacked.push_back(attribute);
  listener_.lacked(attribute);
}

void Recorder::drew_nothing() {
  outcome_.empty_picture = true;
  listener_.drew_nothing();
}

void Recorder::resampled(const field::ScalarField& grid, const WorkFact& fact, const StageTime& time) {
  outcome_.stages.push_back({StageName::resample, std::nullopt, time});
  if (again_) return;
  outcome_.work.push_back(fact);
  listener_.resampled(grid, fact, time);
}

void Recorder::worked(const WorkFact& fact) {
  if (again_) return;
  outcome_.work.push_back(fact);
  listener_.worked(fact);
}

void Recorder::placed(const PlacedField& placed) {
  if (!outcome_.placed) outcome_.placed = placed;
  listener_.placed(placed);
}

void Recorder::extracted(const ExtractedSurface& surface) {
  const extract::ExtractStats& stats = surface.stats;
  outcome_.stages.push_back({StageName::classify, surface.iso, stats.classify});
  if (stats.device) {
    outcome_.stages.push_back({StageName::compile, surface.iso, stats.device->compile});
    outcome_.stages.push_back({StageName::upload, surface.iso, stats.device->upload});
    outcome_.bytes_uploaded += stats.device->bytes_uploaded;
  }
  outcome_.stages.push_back({StageName::count, surface.iso, stats.count});
  outcome_.stages.push_back({StageName::emit, surface.iso, stats.emit});
  outcome_.extractions.push_back({surface.iso, surface.asked, surface.triangles, surface.work, grid_});
  listener_.extracted(surface);
}

void Recorder::verified(const VerificationRecord& record) {
  outcome_.stages.push_back({StageName::verify, record.iso, record.time});
  outcome_.verifications.push_back(record);
  outcome_.verifications.back().grid = grid_;
  listener_.verified(record);
}

void Recorder::carried(const CarriedAttributes& attributes) {
  outcome_.stages.push_back({StageName::attributes, attributes.iso, attributes.time});
  for (const AttributeRecord& record : attributes.attributes) {
    outcome_.attributes.push_back(record);
    outcome_.attributes.back().grid = grid_;
  }
  listener_.carried(attributes);
}

void Recorder::picked(const PieceRecord& record) {
  outcome_.stages.push_back({StageName::pieces, record.iso, record.facts.time});
  outcome_.pieces.push_back(record);
  outcome_.pieces.back().grid = grid_;
  listener_.picked(record);
}

void Recorder::relaxed(const RelaxRecord& record) {
  outcome_.relaxations.push_back(record);
  outcome_.relaxations.back().grid = grid_;
  listener_.relaxed(record);
}

void Recorder::smoothed(const SmoothRecord& record) {
  outcome_.stages.push_back({StageName::smooth, record.iso, record.facts.time});
  outcome_.smoothings.push_back(record);
  outcome_.smoothings.back().grid = grid_;
  listener_.smoothed(record);
}

void Recorder::simplified(const MeshSimplification& simplification) {
  outcome_.stages.push_back({StageName::simplify, simplification.iso, simplification.facts.time});
  outcome_.simplifications.push_back(simplification);
  outcome_.simplifications.back().grid = grid_;
  listener_.simplified(simplification);
}

void Recorder::coloured(const ColourRecord& record) {
  outcome_.colours.push_back(record);
  outcome_.colours.back().grid = grid_;
  listener_.coloured(record);
}

void Recorder::shaded(double iso, const WorkFact& fact, const StageTime& time) {
  outcome_.stages.push_back({StageName::normals, iso, time});
  outcome_.work.push_back(fact);
  listener_.shaded(iso, fact, time);
}

void Recorder::measured(const MeshError& error, const StageTime& time) {
  outcome_.stages.push_back({StageName::error, error.iso, time});
  outcome_.errors.push_back({error, grid_});
  listener_.measured(error, time);
}

void Recorder::packed(const MeshPackingRecord& record) {
  outcome_.packings.push_back(record);
  listener_.packed(record);
}

void Recorder::written(const WrittenOutput& output) {
  if (!output.isos.empty()) outcome_.stages.push_back({StageName::write, std::nullopt, output.time});
  for (; located_ < outcome_.written.size(); ++located_) {
    outcome_.written[located_].first_file = outcome_.files.size();
    outcome_.written[located_].files = output.files.size();
  }
  outcome_.files.insert(outcome_.files.end(), output.files.begin(), output.files.end());
  listener_.written(output);
}

void Recorder::wrote_field(const WrittenField& field) {
  outcome_.stages.push_back({StageName::write, std::nullopt, field.time});
  outcome_.work.insert(outcome_.work.end(), field.work.begin(), field.work.end());
  outcome_.files.push_back({field.job.path, field.bytes});
  listener_.wrote_field(field);
}

void Recorder::recorded(const std::vector<MeshRecord>& meshes, const StageTime& time) {
  outcome_.stages.push_back({StageName::mesh_facts, std::nullopt, time});
  outcome_.meshes.insert(outcome_.meshes.end(), meshes.begin(), meshes.end());
  listener_.recorded(meshes, time);
}

}  // namespace isoextract::convert
