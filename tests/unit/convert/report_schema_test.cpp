// The schemas in docs list exactly the words of the code's enums.
#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "check/mesh_requirement.hpp"
#include "check/shells.hpp"
#include "convert/json_values.hpp"
#include "convert/outcome.hpp"

namespace isoextract::convert {
namespace {

using Words = std::set<Json>;

template <class E>
Words words(std::initializer_list<Json> others = {}) {
  Words all(others);
  for (const auto& entry : words_of(E{})) all.insert(entry.word);
  return all;
}

Words kinds_of_errors() {
  Words all;
  // A report is about one frame, so it never has ErrorCode::frames.
  for (const ErrorCode code : {ErrorCode::usage, ErrorCode::input, ErrorCode::unavailable, ErrorCode::output,
                               ErrorCode::verification, ErrorCode::cancelled}) {
    all.insert(json_of(Error{code, "", {}})["kind"]);
  }
  return all;
}

Words reasons_of_errors() {
  Words all;
  for (const ErrorCode code :
       {ErrorCode::input, ErrorCode::empty_grid, ErrorCode::no_surface, ErrorCode::out_of_memory, ErrorCode::output}) {
    all.insert(json_of(Error{code, "", {}})["reason"]);
  }
  return all;
}

Words kind_names() { return {kind_name(field::FieldKind::level_set), kind_name(field::FieldKind::density)}; }

Words timed_stages() {
  Words all;
  for (const StageInfo& stage : kStages) {
    if (stage.is_timed) all.insert(stage.word);
  }
  return all;
}

Words units() {
  Words all{nullptr};
  for (const LengthUnit& unit : length_units()) all.insert(unit.name);
  return all;
}

const std::map<std::string, Words>& words_of_report() {
  static const std::map<std::string, Words> all{
      {"/properties/status", {"done", "failed"}},
      {"/properties/error/properties/kind", kinds_of_errors()},
      {"/properties/error/properties/exit_code", {1, 2, 3, 4, 6, 130}},
      {"/properties/error/properties/reason", reasons_of_errors()},
      {"/properties/options/properties/axis_order", words<volume_io::AxisOrder>({nullptr})},
      {"/properties/options/properties/raw/properties/dtype", words<field::SampleType>()},
      {"/properties/options/properties/raw/properties/endian", {"little", "big"}},
      {"/properties/options/properties/inside", words<field::FieldKind>({nullptr})},
      {"/properties/options/properties/particles/properties/method", words<points::Method>()},
      {"/properties/options/properties/particles/properties/deposit", words<points::Deposit>()},
      {"/properties/options/properties/particles/properties/not_finite", words<points::BadParticles>()},
      {"/properties/options/properties/attributes/items/properties/kind", words<AttributeKind>({nullptr})},
      {"/properties/options/properties/backend", words<Backend>()},
      {"/properties/options/properties/method", words<extract::Method>()},
      {"/properties/options/properties/voxel_faces", words<extract::VoxelFaces>()},
      {"/properties/options/properties/normals", words<Normals>()},
      {"/properties/options/properties/nan", words<extract::NanPolicy>()},
      {"/properties/options/properties/empty", words<EmptyPolicy>()},
      {"/properties/options/properties/blurs/items/properties/kind", words<BlurKind>()},
      {"/properties/options/properties/pieces/properties/least/properties/measure", words<edit::PieceMeasure>()},
      {"/properties/options/properties/smooth/properties/method", words<edit::SmoothMethod>()},
      {"/properties/options/properties/filters/items/properties/filter", words<volume_io::LevelSetFilter>()},
      {"/properties/options/properties/kernel", words<field::ResampleKernel>()},
      {"/properties/options/properties/space", words<Space>()},
      {"/properties/options/properties/up", words<UpAxis>()},
      {"/properties/options/properties/to_space", words<AnatomicalSpace>({nullptr})},
      {"/properties/options/properties/format", words<mesh_io::MeshFormat>({"vdb", "png"})},
      {"/properties/options/properties/compression", words<mesh_io::Compression>()},
      {"/properties/options/properties/error", words<field::Interpolation>({nullptr})},
      {"/properties/attributes/items/properties/kind", words<AttributeKind>()},
      {"/properties/device/properties/backend", words<Backend>()},
      {"/properties/input/properties/sample_type", words<field::SampleType>()},
      {"/properties/input/properties/kind", kind_names()},
      {"/properties/input/properties/inside", words<field::FieldKind>()},
      {"/properties/particles/properties/method", words<points::Method>()},
      {"/properties/stages/items/properties/stage", timed_stages()},
      {"/properties/verification/items/properties/backends/items", {"cpu", "gpu"}},
      {"/properties/smoothings/items/properties/method", words<edit::SmoothMethod>()},
      {"/properties/simplifications/items/properties/asked/properties/unit", {"voxel", "world"}},
      {"/properties/packings/items/properties/compression", words<mesh_io::Compression>()},
      {"/$defs/colormap", words<edit::Colormap>()},
      {"/$defs/error/properties/interpolant", words<field::Interpolation>()},
      {"/$defs/work/items/properties/what", words<WorkTopic>()},
      {"/$defs/work/items/properties/done", words<WorkDone>()},
  };
  return all;
}

const std::map<std::string, Words>& words_of_info() {
  static const std::map<std::string, Words> all{
      {"/properties/grids/items/properties/kind",
       {kind_name(field::FieldKind::level_set), kind_name(field::FieldKind::density), nullptr}},
      {"/properties/particles/properties/method", words<points::Method>()},
      {"/properties/field/properties/kind", kind_names()},
      {"/properties/field/properties/inside", words<field::FieldKind>()},
      {"/properties/field/properties/type", words<field::SampleType>()},
  };
  return all;
}

const std::map<std::string, Words>& words_of_check() {
  static const std::map<std::string, Words> all{
      {"/properties/unit", units()},
      {"/properties/required/items/properties/requirement", words<check::Requirement>()},
      {"/properties/findings/items/properties/who", {"slicer", "engine"}},
      {"/$defs/shell", words<check::Shell>()},
  };
  return all;
}

void find_enums(const Json& schema, const std::string& at, std::map<std::string, Words>& found) {
  if (schema.is_object()) {
    for (const auto& [key, value] : schema.items()) {
      if (key == "enum" && value.is_array()) {
        Words& listed = found[at];
        for (const Json& word : value) EXPECT_TRUE(listed.insert(word).second) << at << " lists " << word << " twice";
      } else {
        find_enums(value, at + "/" + key, found);
      }
    }
  } else if (schema.is_array()) {
    for (std::size_t i = 0; i < schema.size(); ++i) find_enums(schema[i], at + "/" + std::to_string(i), found);
  }
}

std::string text_of(const Words& all) { return Json(std::vector<Json>(all.begin(), all.end())).dump(); }

// Removes the prefix of the schema's path to the description of an input.
std::string within_input(const std::string& at) { return at.substr(std::min(at.find("/properties"), at.size())); }

void expect_words(const std::string& schema, const std::map<std::string, Words>& of_code) {
  std::ifstream file(std::string(ISOEXTRACT_SOURCE_DIR) + "/docs/" + schema);
  ASSERT_TRUE(file.good()) << schema;
  std::map<std::string, Words> found_words;
  find_enums(Json::parse(file), "", found_words);
  std::map<std::string, Words> listed;
  for (auto& [at, found] : found_words) listed[schema.starts_with("info") ? within_input(at) : at] = std::move(found);
  for (const auto& [at, found] : listed) {
    const auto known = of_code.find(at);
    if (known == of_code.end()) {
      ADD_FAILURE() << schema << ": " << at << " lists words, and this test does not know of which enum";
    } else {
      EXPECT_EQ(text_of(found), text_of(known->second)) << schema << ": " << at;
    }
  }
  for (const auto& [at, expected] : of_code) EXPECT_TRUE(listed.contains(at)) << schema << " lists no words at " << at;
}

TEST(Schemas, ListWordsOfEnums) {
  expect_words("report.schema.json", words_of_report());
  expect_words("info.schema.json", words_of_info());
  expect_words("check.schema.json", words_of_check());
}

}  // namespace
}  // namespace isoextract::convert
