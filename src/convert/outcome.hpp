// What one conversion did, and the document that `--report FILE.json` writes of it. docs/report.schema.json describes
// it; the two change together, and kSchemaVersion rises where a reader of the old document would misread the new one.
//
// What only some conversions know is optional here and absent or null in the document. A later section is one more
// optional member, a line in report_of, and an optional property of the schema.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/stopwatch.hpp"
#include "base/words.hpp"
#include "convert/attribute_source.hpp"
#include "convert/conversion_job.hpp"
#include "convert/iso_values.hpp"
#include "convert/json_values.hpp"
#include "convert/mesh_error.hpp"
#include "convert/mesh_packing.hpp"
#include "convert/mesh_pieces.hpp"
#include "convert/mesh_relax.hpp"
#include "convert/mesh_simplify.hpp"
#include "convert/mesh_smooth.hpp"
#include "convert/particle_source.hpp"
#include "convert/verification.hpp"
#include "convert/vertex_colours.hpp"
#include "convert/work_facts.hpp"
#include "mesh/metrics.hpp"
#include "mesh/topology.hpp"

namespace isoextract::convert {

inline constexpr int kReportSchemaVersion = 1;

struct InputFacts {
  std::string path;    // as given
  std::string format;  // "OpenVDB"
  std::string name;    // of the grid, or the file's stem
  std::string world_space;
  std::string length_unit;
  std::string creator;
  bool sparse = false;
  field::SampleType type = field::SampleType::f32;
  field::FieldKind kind = field::FieldKind::density;
  field::ValueScale scale;
  field::Affine index_to_world;
  field::IndexBox box;                      // of all samples, or of the active voxels
  std::uint64_t samples = 0;                // all of them, or the active voxels
  std::uint64_t stored_bytes = 0;           // of samples in memory
  std::optional<std::uint64_t> file_bytes;  // of the file that was named; none for demo fields
};

[[nodiscard]] InputFacts input_facts(const std::string& path, const field::ScalarField& field);

// The words are those of the report.
enum class StageName {
  open,
  read,
  particles_to_field,
  read_attributes,
  filter,
  resample,
  statistics,
  classify,
  compile,
  upload,
  count,
  emit,
  verify,
  attributes,
  pieces,
  smooth,
  simplify,
  normals,
  error,
  mesh_facts,
  write,
};
constexpr auto words_of(StageName /*type*/) {
  return std::array{Word{StageName::open, "open"},
                    Word{StageName::read, "read"},
                    Word{StageName::particles_to_field, "particles to field"},
                    Word{StageName::read_attributes, "read attributes"},
                    Word{StageName::filter, "filter"},
                    Word{StageName::resample, "resample"},
                    Word{StageName::statistics, "statistics"},
                    Word{StageName::classify, "classify"},
                    Word{StageName::compile, "compile"},
                    Word{StageName::upload, "upload"},
                    Word{StageName::count, "count"},
                    Word{StageName::emit, "emit"},
                    Word{StageName::verify, "verify"},
                    Word{StageName::attributes, "attributes"},
                    Word{StageName::pieces, "pieces"},
                    Word{StageName::smooth, "smooth"},
                    Word{StageName::simplify, "simplify"},
                    Word{StageName::normals, "normals"},
                    Word{StageName::error, "error"},
                    Word{StageName::mesh_facts, "mesh facts"},
                    Word{StageName::write, "write"}};
}

struct StageRecord {
  StageName stage = StageName::open;
  std::optional<double> iso;  // where the stage belongs to one surface
  StageTime time;
};

struct ExtractionRecord {
  double iso = 0;
  IsoChoice asked;
  std::uint64_t triangles = 0;
  std::vector<WorkFact> work;
  std::string grid = {};  // whose surface it is, where the job has several
};

// The error of one surface.
struct MeasuredError : MeshError {
  std::string grid = {};  // whose surface it is, where the job has several
};

// Of a mesh that was written.
struct MeshRecord {
  double iso = 0;
  std::string file;  // "-" is standard output
  std::string name;  // of the mesh in the file
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  glm::dvec3 origin{0.0};
  mesh::Bounds bounds;
  mesh::MeshSize size;  // its volume means something only where the mesh is closed
  mesh::Topology topology;
  ComponentTable component_table;
  std::optional<MeshError> error;  // where it was measured
  std::string grid = {};           // whose surface it is, where the job has several
};

// Fails where the memory to look at the mesh is not there.
[[nodiscard]] Result<MeshRecord> mesh_record(double iso, const std::string& file, const mesh::Mesh& mesh,
                                             const Context& context);

// The same record with what was found out since, and the name and the number of vertices of the mesh as it is written.
[[nodiscard]] MeshRecord record_as_written(MeshRecord record, const std::string& file, const mesh::Mesh& mesh,
                                           std::optional<MeshError> error);

// What a conversion did, or how far it came before it failed.
// What of a surface went to one of the outputs, after all that changes it; pieces in files of their own are one each.
struct WrittenSurface {
  double iso = 0;
  std::size_t output = 0;  // of the job's
  std::uint64_t triangles = 0;
  // The range of Outcome::files that holds it; empty until they are written.
  std::size_t first_file = 0;
  std::size_t files = 0;
  std::string grid = {};  // where the job has several
};

struct Outcome {
  std::string backend;  // "cpu" or "gpu"; if it could not be opened, what was asked for; empty if that was not tried
  std::string device;   // the processor's or the GPU's name; empty if it could not be opened
  int threads = 0;
  std::optional<InputFacts> input;          // absent if it could not be read
  std::vector<InputFacts> more_grids;       // of the input, where several were asked for: those after the first
  std::optional<ParticleRecord> particles;  // absent for volumes
  std::optional<PlacedField> placed;        // what placed the meshes
  std::vector<ResolvedIso> isos;            // of all outputs, where some were no numbers; grid by grid
  std::vector<StageRecord> stages;
  StageTime total;
  std::uint64_t bytes_read = 0;
  std::uint64_t bytes_uploaded = 0;   // to a device; 0 on the CPU
  std::uint64_t peak_memory = 0;      // of the process
  std::uint64_t reserved_memory = 0;  // the most that this conversion reserved at a time
  std::vector<WorkFact> work;         // of reading, filtering, resampling and writing a field
  std::vector<ExtractionRecord> extractions;
  std::vector<VerificationRecord> verifications;
  std::vector<AttributeRecord> attributes;
  std::vector<std::string> lacked_attributes;  // optional ones that the input does not have
  std::vector<MeasuredError> errors;           // where they were measured, before the mesh is split into pieces
  std::vector<PieceRecord> pieces;
  std::vector<RelaxRecord> relaxations;  // of closed surface nets
  std::vector<SmoothRecord> smoothings;
  std::vector<MeshSimplification> simplifications;
  std::vector<ColourRecord> colours;
  std::vector<MeshPackingRecord> packings;
  std::vector<MeshRecord> meshes;
  std::vector<WrittenSurface> written;
  std::vector<meshes::WrittenFile> files;
  bool empty_picture = false;  // there are surfaces, and a picture shows none of them
  std::vector<std::string> notes;
  std::optional<Error> error;  // why the conversion failed

  [[nodiscard]] bool done() const { return !error; }
};

// The report's document. `job` is null where the options gave none, which is why the outcome failed. `arguments` are
// the words of the command line without the program, `memory_limit` the budget's; `hint` is the outcome's hint in
// words, which only the command line has.
[[nodiscard]] Json report_of(const ConversionJob* job, const Outcome& outcome,
                             const std::vector<std::string>& arguments, std::uint64_t memory_limit,
                             const std::string& hint);

}  // namespace isoextract::convert
