// What one conversion did, for `--report FILE.json`. docs/report.schema.json describes the document; the two change
// together, and kSchemaVersion rises where a reader of the old document would misread the new one.
//
// What only some conversions know is optional here and absent or null in the document. A later section is one more
// optional member, a line in json_of, and an optional property of the schema.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/stopwatch.hpp"
#include "convert/json_values.hpp"
#include "convert/verification_record.hpp"
#include "convert/work_facts.hpp"
#include "mesh/metrics.hpp"
#include "mesh/topology.hpp"

namespace isoextract::convert {

inline constexpr int kReportSchemaVersion = 1;

// Every option of the conversion after defaults, in the words of the command line.
struct ResolvedOptions {
  std::string method;
  std::vector<double> isos;
  std::string normals;
  std::string nan;
  std::string empty;
  bool cap = false;
  std::optional<field::Box> roi;
  std::optional<glm::ivec3> resolution;
  std::string space;
  std::string up;
  bool turned_to_y_up = false;  // whether (x, y, z) became (x, z, -y)
  double scale = 1;
  std::string unit;  // empty if none was named
  std::string format;
  bool ascii = false;
  std::string simplify;  // "0.1voxel", "0.5world"; empty if nothing is simplified
  std::string error;     // "trilinear", "tricubic"; empty if it is not measured
  bool verify = false;
  std::uint64_t memory_limit = 0;
};

struct InputFacts {
  std::string path;    // as given
  std::string format;  // "OpenVDB"
  std::string name;    // of the grid, or the file's stem
  std::string world_space;
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

struct StageRecord {
  std::string stage;          // "open", "read", "resample", "classify", "compile", "upload", "count", "emit", "verify",
                              // "simplify", "error", "mesh facts", "statistics", "write"
  std::optional<double> iso;  // where the stage belongs to one surface
  StageTime time;
};

struct ExtractionRecord {
  double iso = 0;
  std::uint64_t triangles = 0;
  std::vector<WorkFact> work;
};

struct DistanceRange {
  double lower = 0;
  double upper = 0;
};

// Of a mesh that was simplified: the Hausdorff distance to what it was, at least and at most.
struct SimplificationRecord {
  double iso = 0;
  double asked = 0;
  bool asked_in_voxels = true;  // else in the mesh's units
  DistanceRange voxels;
  DistanceRange world;
  std::uint64_t triangles_before = 0;
  std::uint64_t triangles_after = 0;
  int passes = 0;
  StageTime time;
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
  std::optional<Json> error;  // what --error measured of it
};

[[nodiscard]] MeshRecord mesh_record(double iso, const std::string& file, const mesh::Mesh& mesh);

struct FileRecord {
  std::string path;
  std::uint64_t bytes = 0;
};

struct ConversionReport {
  std::vector<std::string> arguments;  // the words of the command line, without the program
  ResolvedOptions options;
  std::string backend;  // "cpu" or "gpu"; if it could not be opened, what was asked for
  std::string device;   // the processor's or the GPU's name
  int threads = 0;
  std::optional<InputFacts> input;                 // absent if it could not be read
  std::optional<field::Affine> output_from_index;  // what placed the meshes
  std::optional<field::IndexBox> region;           // samples that --roi holds
  std::vector<StageRecord> stages;
  StageTime total;
  std::uint64_t bytes_read = 0;
  std::uint64_t bytes_uploaded = 0;  // to a device; 0 on the CPU
  std::uint64_t peak_memory = 0;
  std::vector<WorkFact> work;  // of reading and resampling
  std::vector<ExtractionRecord> extractions;
  std::vector<VerificationRecord> verifications;
  std::vector<SimplificationRecord> simplifications;
  std::vector<MeshRecord> meshes;
  std::vector<FileRecord> files;
  std::vector<std::string> notes;  // what was shown as notes
  std::optional<Error> error;      // why the conversion failed
};

[[nodiscard]] Json json_of(const ConversionReport& report);

}  // namespace isoextract::convert
