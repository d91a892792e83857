// Events on their way to whoever listens, written into the outcome.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "convert/events.hpp"
#include "convert/outcome.hpp"

namespace isoextract::convert {

class Recorder final : public Events {
 public:
  Recorder(Outcome& outcome, Events& listener) : outcome_(outcome), listener_(listener) {}

  void note(const std::string& text) override;
  void opened(const extract::Extractor& extractor, const StageTime& time) override;
  void read(const std::string& input, const field::ScalarField& field, const StageTime& time) override;
  void made_field(const ParticleRecord& record) override;
  void filtered(const WorkFact& fact, const StageTime& time) override;
  void resolved(const std::vector<ResolvedIso>& isos, const std::optional<StageTime>& time) override;
  void read_attributes(const StageTime& time) override;
  void lacked(const std::string& attribute) override;
  void drew_nothing() override;
  void resampled(const field::ScalarField& grid, const WorkFact& fact, const StageTime& time) override;
  void worked(const WorkFact& fact) override;
  void placed(const PlacedField& placed) override;
  void extracted(const ExtractedSurface& surface) override;
  void clipped(double iso, const edit::ClipFacts& facts) override { listener_.clipped(iso, facts); }
  void verified(const VerificationRecord& record) override;
  void carried(const CarriedAttributes& attributes) override;
  void picked(const PieceRecord& record) override;
  void relaxed(const RelaxRecord& record) override;
  void smoothed(const SmoothRecord& record) override;
  void simplified(const MeshSimplification& simplification) override;
  void coloured(const ColourRecord& record) override;
  void shaded(double iso, const WorkFact& fact, const StageTime& time) override;
  void measured(const MeshError& error, const StageTime& time) override;
  void packed(const MeshPackingRecord& record) override;
  void written(const WrittenOutput& output) override;
  void wrote_field(const WrittenField& field) override;
  void recorded(const std::vector<MeshRecord>& meshes, const StageTime& time) override;

  // Call it in jobs with several grids before one is read: records of surfaces name that grid from then on. If the grid
  // was read before, what is reported until end_reading() was reported then: only times are recorded.
  void begin_grid(const std::optional<std::string>& grid);
  void end_reading() { again_ = false; }
  // The label of that grid; empty where the job has one.
  [[nodiscard]] const std::string& grid() const { return grid_; }

 private:
  Outcome& outcome_;
  Events& listener_;
  std::size_t located_ = 0;  // of Outcome::written: those whose files are known
  std::vector<std::optional<std::string>> begun_;
  bool again_ = false;
  std::string grid_;
};

}  // namespace isoextract::convert
