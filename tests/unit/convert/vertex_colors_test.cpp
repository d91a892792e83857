#include "convert/stages/vertex_colors.hpp"

#include <fstream>
#include <vector>

#include <gtest/gtest.h>

#include "convert/attribute_source.hpp"
#include "edit/colormap.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::convert {
namespace {

TEST(Materials, MakeOuterSurfacesTranslucent) {
  ConversionJob job;
  SurfaceList isos({1, 3, 2});
  EXPECT_FALSE(material_of(job, isos, 1, field::FieldKind::density));
  job.color = ColorChoice{{}, edit::Colormap::gray, {}};
  const auto opacity = [&](double iso, field::FieldKind kind) { return material_of(job, isos, iso, kind)->opacity; };
  EXPECT_EQ(opacity(1, field::FieldKind::density), 0.25);
  EXPECT_EQ(opacity(2, field::FieldKind::density), 0.625);
  EXPECT_EQ(opacity(3, field::FieldKind::density), 1);
  EXPECT_EQ(opacity(3, field::FieldKind::level_set), 0.25);
  EXPECT_EQ(material_of(job, isos, 1, field::FieldKind::density)->color, glm::dvec3(0));
  EXPECT_NEAR(material_of(job, isos, 2, field::FieldKind::density)->color->x, 0.214, 0.003);
  job.opacity = {0.1, 0.2, 0.3};
  EXPECT_EQ(opacity(2, field::FieldKind::density), 0.3);
  job.color.reset();
  job.opacity = {0.5};
  const auto plain = material_of(job, isos, 1, field::FieldKind::density);
  ASSERT_TRUE(plain);
  EXPECT_EQ(*plain, (mesh::Material{{}, 0.5}));
  isos = SurfaceList({1, 3, 2, 3});  // a found value may equal a given one; both have one surface
  job.opacity = {0.1, 0.2, 0.3, 0.4};
  EXPECT_EQ(opacity(3, field::FieldKind::density), 0.2);
  job.opacity.clear();
  job.color = ColorChoice{{}, edit::Colormap::gray, {}};
  EXPECT_EQ(opacity(2, field::FieldKind::density), 0.625);
  EXPECT_EQ(opacity(3, field::FieldKind::density), 1);
  isos = SurfaceList({1});
  job.color = ColorChoice{{}, edit::Colormap::gray, {}};
  EXPECT_EQ(opacity(1, field::FieldKind::density), 1);
}

TEST(AttributeLocation, DistinguishesFilesFromGrids) {
  const auto place = [](std::string from, std::string name = "n") {
    const AttributeLocation found = attribute_location({std::move(name), std::move(from), true});
    return found.file + "|" + found.grid.value_or("-");
  };
  EXPECT_EQ(place("temperature"), "|temperature");
  EXPECT_EQ(place("velocity[x]"), "|velocity[x]");
  EXPECT_EQ(place("nowhere/b.NII.GZ"), "nowhere/b.NII.GZ|-");
  EXPECT_EQ(place("b.vdb[velocity[x]]"), "b.vdb|velocity[x]");
  EXPECT_EQ(place("demo:sphere?size=8"), "demo:sphere?size=8|-");
  const test::TempFolder folder;
  const std::string file = (folder / "plain").string();
  EXPECT_EQ(place(file), "|" + file);
  std::ofstream(file) << "is there";
  EXPECT_EQ(place(file), file + "|-");
  EXPECT_EQ(place(file, file), "|" + file);  // the attribute's own name means a grid
  EXPECT_EQ(place((folder / "").string()), (folder / "").string() + "|-");
}

}  // namespace
}  // namespace isoextract::convert
