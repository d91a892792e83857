#include "convert/iso_values.hpp"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "convert/conversion.hpp"
#include "field/statistics.hpp"
#include "support/outcomes.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::convert {
namespace {

IsoChoice choice(const std::string& word) {
  const auto found = iso_choice_of(word);
  EXPECT_TRUE(found) << word;
  return found.value_or(IsoChoice());
}

// Returns a field with the values 0, 1, ..., 9 and 90, 91, ..., 99.
field::ScalarField two_heaps(const std::string& name = "heaps") {
  auto owner = std::make_shared<std::vector<float>>();
  for (int i = 0; i < 20; ++i) owner->push_back(static_cast<float>(i < 10 ? i : 80 + i));
  field::ScalarField field;
  field.samples = field::DenseSamples{field::SampleType::f32, {5, 2, 2}, owner, owner->data()};
  field.name = name;
  return field;
}

field::ScalarField constant_field(float value = 5) {
  auto owner = std::make_shared<std::vector<float>>(8, value);
  field::ScalarField field;
  field.samples = field::DenseSamples{field::SampleType::f32, {2, 2, 2}, owner, owner->data()};
  field.source = "flat.raw";
  return field;
}

TEST(IsoChoice, ParsesItsOwnText) {
  for (const char* word : {"auto", "zero", "p0", "p99", "p99.9", "p0.000001", "p100"})
    EXPECT_EQ(text_of(choice(word)), word);
  EXPECT_EQ(text_of(choice("p050.50")), "p50.5");
  for (const char* word : {"", "p", "Auto", "AUTO", "auto ", "p-1", "p101", "p1e1", "99", "P99", "p99%", "pnan"}) {
    EXPECT_FALSE(iso_choice_of(word)) << word;
  }
  EXPECT_EQ(text_of(IsoChoice(1.0 / 3)), "0.3333333333333333");
  EXPECT_EQ(text_of(IsoChoice(-1e-30)), "-1e-30");
  EXPECT_NE(IsoChoice(50), IsoChoice::percentile(field::Percent(50)));
}

TEST(SurfaceId, HoldsIsoValueOrLabel) {
  const SurfaceId iso = 5;
  const SurfaceId label = Label{5};
  EXPECT_NE(iso, label);
  EXPECT_EQ(iso.name(), "iso 5");
  EXPECT_EQ(label.name(), "label 5");
  EXPECT_EQ(label.iso_or_zero(), 0);
  // Labels stay integers in JSON, also those that a double cannot represent.
  const SurfaceId large = Label{9007199254740993};
  EXPECT_EQ(json_of(large).dump(), "9007199254740993");
  EXPECT_EQ(surface_id_of(json_of(large)), large);
  EXPECT_EQ(surface_id_of(json_of(iso)), iso);
  EXPECT_THROW(static_cast<void>(iso.label()), std::bad_variant_access);
  EXPECT_THROW(static_cast<void>(label.iso()), std::bad_variant_access);
  // The meshes of a mesh file are texts in JSON.
  const SurfaceId third = FileMesh{3};
  EXPECT_EQ(third.name(), "mesh 3");
  EXPECT_EQ(third.at_text(), " of mesh 3");
  EXPECT_EQ(SurfaceId(kWholeFile).at_text(), "");
  for (const SurfaceId& mesh : {third, SurfaceId(kWholeFile)}) EXPECT_EQ(surface_id_of(json_of(mesh)), mesh);
  // Terrain is iso 0 in records, but texts do not name an iso value.
  const SurfaceId terrain = SurfaceId::terrain();
  EXPECT_EQ(terrain, SurfaceId(0.0));
  EXPECT_EQ(json_of(terrain), json_of(SurfaceId(0.0)));
  EXPECT_EQ(terrain.name(), "terrain");
  EXPECT_EQ(terrain.at_text(), "");
  EXPECT_EQ(place_text({IsoChoice::terrain(), terrain, {}}), "");
  EXPECT_TRUE(terrain.is_only_surface());
  EXPECT_FALSE(SurfaceId(0.0).is_only_surface());
  // A double cannot represent this number.
  EXPECT_EQ(text_of(IsoChoice::label(9007199254740993)), "label 9007199254740993");
}

TEST(ResolveIsos, KeepsOrderOfChoices) {
  const std::vector<IsoChoice> asked{choice("p50"), -3, choice("auto"), choice("p100"), choice("p5.1")};
  const field::ScalarField field = two_heaps();
  const auto found = resolve_isos(asked, field, false, Context());
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->size(), asked.size());
  for (std::size_t i = 0; i < asked.size(); ++i) EXPECT_EQ((*found)[i].asked, asked[i]);
  EXPECT_EQ((*found)[0].id, 9);
  EXPECT_EQ((*found)[0].found_by, "percentile 50 of the samples");
  EXPECT_EQ((*found)[1].id, -3);
  EXPECT_EQ((*found)[1].found_by, "");
  const field::IsoSuggestion suggested = field::suggest_iso(field, field::measure_statistics(field));
  EXPECT_EQ((*found)[2].id, suggested.iso);
  EXPECT_EQ((*found)[2].found_by, suggested.method);
  EXPECT_EQ((*found)[3].id, 99);
  EXPECT_EQ((*found)[4].id, 1);
  EXPECT_EQ(text_of((*found)[0]), "p50 (9)");
  EXPECT_EQ(text_of((*found)[1]), "-3");
}

TEST(ResolveIsos, SuggestsZeroForLevelSet) {
  field::ScalarField field = constant_field();
  field.kind = field::FieldKind::level_set;
  const auto found = resolve_isos(std::vector{choice("auto")}, field, false, Context());
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->front().id, 0);
  EXPECT_EQ(found->front().found_by, "the zero of the level set");
}

TEST(ResolveIsos, DistinguishesGivenZeroFromDefault) {
  field::ScalarField field = constant_field(0.3F);  // no label
  const auto given = resolve_isos(std::vector{choice("zero")}, field, false, Context());
  ASSERT_FALSE(given);
  EXPECT_EQ(given.error().message,
            "flat.raw: the iso value 'zero' is for level sets: expected a level set, found a density");
  const auto none = resolve_isos(std::vector{IsoChoice::zero_by_default()}, field, false, Context());
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("a density has no default iso value"), std::string::npos);
  field.kind = field::FieldKind::level_set;
  const auto both = resolve_isos(std::vector{choice("zero"), IsoChoice::zero_by_default()}, field, false, Context());
  ASSERT_TRUE(both) << both.error().message;
  EXPECT_EQ(text_of(both->at(0)), "zero (0)");
  EXPECT_EQ(text_of(both->at(1)), "0");
  EXPECT_EQ(place_text(both->at(1)), " at iso 0");
}

TEST(ResolveIsos, RefusesSuggestionForConstantField) {
  const std::vector<IsoChoice> asked{choice("auto")};
  const auto refused = resolve_isos(asked, constant_field(), false, Context());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::no_surface);
  EXPECT_EQ(refused.error().message,
            "flat.raw: expected two groups of sample values, to choose an iso value between them; found 5 everywhere");
  const auto fine = resolve_isos(asked, constant_field(), true, Context());
  ASSERT_TRUE(fine);
  EXPECT_EQ(fine->front().id, 5);  // samples equal to the iso value are outside, so there is no surface
  // Percentiles exist in a constant field.
  EXPECT_EQ(resolve_isos(std::vector{choice("p50")}, constant_field(), false, Context())->front().id, 5);
}

TEST(ResolveIsos, ReservesMemoryFirst) {
  const Context small{MemoryBudget(1000)};
  const auto refused = resolve_isos(std::vector{choice("p50")}, two_heaps(), false, small);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  EXPECT_TRUE(resolve_isos(std::vector<IsoChoice>{0.5}, two_heaps(), false, small));
}

TEST(ResolveIsos, UsesMethodValueForParticles) {
  const auto found = resolve_isos(std::vector<IsoChoice>{choice("auto"), 0.2}, points::Method::weight, "a.csv");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->at(0).id, 0.15);
  EXPECT_EQ(found->at(0).found_by, "the default of summed weights");
  EXPECT_EQ(found->at(1).id, 0.2);
  const auto refused = resolve_isos(std::vector{choice("p99")}, points::Method::sph, "a.csv");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::usage);
  EXPECT_NE(refused.error().message.find("a.csv: expected a number or 'auto'"), std::string::npos);
  EXPECT_NE(refused.error().message.find("found 'p99'"), std::string::npos);
}

TEST(EachOnce, DropsRepeatedFoundValues) {
  const std::vector<ResolvedIso> isos{
      {choice("p50"), 3, {}}, {3, 3, {}}, {choice("p60"), 3, {}}, {4, 4, {}}, {4, 4, {}}, {choice("auto"), 4, {}}};
  const std::vector<ResolvedIso> once = without_repeats(isos);
  ASSERT_EQ(once.size(), 3U);  // values given as numbers stay, even repeated
  EXPECT_EQ(text_of(once[0].asked), "p50");
  EXPECT_EQ(text_of(once[1].asked), "4");
  EXPECT_EQ(text_of(once[2].asked), "4");
}

// A conversion finds iso values in the whole input, whatever part it extracts, and reports them.
class IsoConversionTest : public testing::Test {
 protected:
  Outcome run(const std::vector<IsoChoice>& isos) {
    job_.source.input = "demo:gyroid?size=24";
    job_.file = MeshFileOptions{mesh_io::MeshFormat::obj};
    job_.outputs = {{(folder_ / "a.obj").string(), isos}};
    Events unheard;
    return convert::run(job_, Context(), unheard);
  }
  static std::vector<double> found(const Outcome& outcome) {
    return test::figures<double>(outcome, StageName::statistics, Key::iso);
  }
  static std::vector<std::string> asked(const Outcome& outcome) {
    return test::figures<std::string>(outcome, StageName::extract, Key::asked);
  }
  test::TempFolder folder_;
  ConversionJob job_;
};

TEST_F(IsoConversionTest, IgnoresRegionAndResolution) {
  const Outcome whole = run({choice("p80")});
  ASSERT_TRUE(whole.done()) << whole.error->message;
  const std::vector<double> iso = found(whole);
  EXPECT_EQ(whole.first(StageName::extract)->id, SurfaceId(iso.at(0)));
  EXPECT_EQ(asked(whole), std::vector<std::string>{"p80"});
  EXPECT_NE(whole.notes.at(0).text.find("iso p80 is "), std::string::npos) << whole.notes.at(0).text;
  job_.source.roi = field::Box{{-0.5, -0.5, -0.5}, {0.2, 0.2, 0.2}};
  EXPECT_EQ(found(run({choice("p80")})), iso);
  job_.source.resolution = glm::ivec3(9);
  EXPECT_EQ(found(run({choice("p80")})), iso);
}

TEST_F(IsoConversionTest, ExtractsEqualValuesOnce) {
  const Outcome outcome = run({0, choice("auto"), choice("p50")});
  ASSERT_TRUE(outcome.done()) << outcome.error->message;
  ASSERT_EQ(found(outcome).size(), 3U);
  EXPECT_EQ(found(outcome)[1], 0);
  EXPECT_EQ(asked(outcome), (std::vector<std::string>{"", "p50"})) << "a number is what it is";
  const auto tells = [](const Note& note) {
    return note.text.find("iso 0 and auto are the same value, 0") != std::string::npos;
  };
  EXPECT_TRUE(std::ranges::any_of(outcome.notes, tells));
}

TEST_F(IsoConversionTest, SkipsStatisticsForGivenNumbers) {
  const Outcome outcome = run({0, 0.5});
  ASSERT_TRUE(outcome.done());
  for (const StageReport& report : outcome.reports) EXPECT_NE(report.stage, StageName::statistics);
}

}  // namespace
}  // namespace isoextract::convert
