// What a conversion tells while it works. All of it is told on the thread that runs the conversion, between stages; how
// far a stage has come stands in Context::progress(), for other threads to look at.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/stopwatch.hpp"
#include "convert/attribute_source.hpp"
#include "convert/iso_values.hpp"
#include "convert/mesh_error.hpp"
#include "convert/mesh_packing.hpp"
#include "convert/mesh_pieces.hpp"
#include "convert/mesh_relax.hpp"
#include "convert/mesh_simplify.hpp"
#include "convert/mesh_smooth.hpp"
#include "convert/outcome.hpp"
#include "convert/particle_source.hpp"
#include "convert/placement.hpp"
#include "convert/verification.hpp"
#include "convert/vertex_colours.hpp"
#include "convert/work_facts.hpp"
#include "edit/half_space_clip.hpp"
#include "extract/extractor.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::convert {

// One surface that was extracted.
struct ExtractedSurface {
  double iso = 0;
  IsoChoice asked;
  std::uint64_t triangles = 0;
  const extract::ExtractStats& stats;
  std::vector<WorkFact> work;
  StageTime time;
};

// Attributes that the vertices of a surface got.
struct CarriedAttributes {
  double iso = 0;
  std::uint64_t vertices = 0;
  std::vector<AttributeRecord> attributes;
  StageTime time;
};

// A file that was written, or that was not because none of its surfaces has triangles (`isos` is empty then).
struct WrittenOutput {
  const OutputFileJob& job;
  std::vector<double> isos;         // of the surfaces in it, in the job's order
  std::vector<std::string> labels;  // of their fields: field_label(); one for each of `isos`
  std::uint64_t triangles = 0;
  std::uint64_t vertices = 0;
  std::vector<meshes::WrittenFile> files;
  StageTime time;
  std::optional<std::uint64_t> open_edges;  // of its meshes, where they were counted: Surface::counts_open_edges
};

// A file that holds the field itself.
struct WrittenField {
  const OutputFileJob& job;
  std::string samples;  // "64 x 64 x 64 samples"
  bool as_half = false;
  std::uint64_t bytes = 0;
  std::vector<WorkFact> work;
  StageTime time;
};

// Every function does nothing unless it is overridden.
class Events {
 public:
  virtual ~Events() = default;

  // Something that was not as one would think: a sentence without its full stop that names no option.
  virtual void note(const std::string& /*text*/) {}
  // What extracts from now on: told before the input is read, and a second time where the CPU takes over from a GPU
  // that cannot do the work. Where the choice was the program's, a note says why.
  virtual void opened(const extract::Extractor&, const StageTime&) {}
  virtual void read(const std::string& /*input*/, const field::ScalarField&, const StageTime&) {}
  virtual void made_field(const ParticleRecord&) {}            // of particles, told after they are read
  virtual void filtered(const WorkFact&, const StageTime&) {}  // a field, told once a filter or blur
  // The iso values, where some were no numbers; a note tells of each of these. The time is that of looking at samples,
  // none for particles.
  virtual void resolved(const std::vector<ResolvedIso>&, const std::optional<StageTime>&) {}
  virtual void read_attributes(const StageTime&) {}         // of a volume
  virtual void lacked(const std::string& /*attribute*/) {}  // an optional one; a note tells why
  virtual void resampled(const field::ScalarField& /*grid*/, const WorkFact&, const StageTime&) {}
  virtual void worked(const WorkFact&) {}  // of reading
  virtual void placed(const PlacedField&) {}
  virtual void extracted(const ExtractedSurface&) {}
  virtual void clipped(double /*iso*/, const edit::ClipFacts&) {}  // told where there are planes
  virtual void verified(const VerificationRecord&) {}
  virtual void carried(const CarriedAttributes&) {}  // told before the mesh is simplified
  virtual void picked(const PieceRecord&) {}         // pieces that stay, and then
  virtual void relaxed(const RelaxRecord&) {}        // told of surface nets, before they are smoothed
  virtual void smoothed(const SmoothRecord&) {}
  virtual void simplified(const MeshSimplification&) {}
  virtual void coloured(const ColourRecord&) {}                              // and after it
  virtual void shaded(double /*iso*/, const WorkFact&, const StageTime&) {}  // where normals were made to fit triangles
  virtual void measured(const MeshError&, const StageTime&) {}
  virtual void drew_nothing() {}                    // of surfaces that are there; a note tells
  virtual void packed(const MeshPackingRecord&) {}  // before its file is written
  virtual void written(const WrittenOutput&) {}
  virtual void wrote_field(const WrittenField&) {}
  virtual void recorded(const std::vector<MeshRecord>&, const StageTime&) {}
};

}  // namespace isoextract::convert
