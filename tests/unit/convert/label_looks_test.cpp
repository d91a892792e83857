#include "convert/detail/label_looks.hpp"

#include <fstream>

#include <gtest/gtest.h>

#include "support/temp_folder.hpp"
#include "volume_io/label_table.hpp"

namespace isoextract::convert {
namespace {

TEST(LabelAppearance, RefusesChangedTable) {
  const test::TempFolder folder;
  const auto path = (folder.path() / "lut.txt").string();
  const auto write = [&](std::string_view text) { std::ofstream(path) << text; };
  write("1 twin 255 0 0 0\n2 twin 0 0 255 0\n3 alone 0 255 0 0\n");
  ConversionJob job;
  job.label_names = LabelTableFile{path, volume_io::LabelTable::read(path, Context())->hash()};
  const auto looks = LabelAppearance::open(job, field::ScalarField(), std::nullopt, Context());
  ASSERT_TRUE(looks) << looks.error().message;
  EXPECT_EQ(looks->name("head", 3), "alone");
  EXPECT_EQ(looks->name("head", 2), "twin label 2");
  EXPECT_EQ(looks->name("head", 9), "head label 9");
  mesh::Mesh mesh;
  ASSERT_TRUE(looks->color(job, 2, mesh, Context()));
  EXPECT_EQ(mesh.material->color, glm::dvec3(0, 0, 1));
  write("1 other 255 0 0 0\n");
  const auto changed = LabelAppearance::open(job, field::ScalarField(), std::nullopt, Context());
  ASSERT_FALSE(changed);
  EXPECT_NE(changed.error().message.find("has changed"), std::string::npos);
}

TEST(LabelAppearance, UsesLabelNamesOfItsLayer) {
  field::ScalarField field;
  field.labels = {{1, "organ", glm::dvec3(1, 0, 0), 0}, {1, "tumor", std::nullopt, 1}, {2, "bone", std::nullopt, 0}};
  const auto first = LabelAppearance::open({}, field, 0, Context());
  const auto second = LabelAppearance::open({}, field, 1, Context());
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->name("seg", 1), "organ");
  EXPECT_EQ(first->name("seg", 2), "bone");
  EXPECT_EQ(second->name("seg", 1), "tumor");
  EXPECT_EQ(second->name("seg", 2), "seg label 2");
  EXPECT_EQ(first->note_of_missing("s", {1, 2}, 0, false), std::nullopt);
  EXPECT_EQ(first->note_of_missing("s", {1}, 0, true)->text,
            "s: no mesh for 1 of the 2 labels that the file names (bone): no sample in the region has them");
  EXPECT_EQ(first->note_of_missing("s", {1}, 2, false), std::nullopt);  // the background has no mesh
  mesh::Mesh mesh;
  ASSERT_TRUE(first->color({}, 1, mesh, Context()));
  EXPECT_EQ(mesh.material->color, glm::dvec3(1, 0, 0));
}

}  // namespace
}  // namespace isoextract::convert
