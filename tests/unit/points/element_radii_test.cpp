// Tests the radii of elements against the published tables, and how particles get them.
#include <limits>

#include <gtest/gtest.h>

#include "points/element_radii.hpp"
#include "unit/points/particles.hpp"

namespace isoextract::points {
namespace {

struct PublishedRadius {
  const char* symbol;
  int number;
  double van_der_waals;
  double covalent;
};

// Copied from the papers: Mantina 2009 (table 12), Alvarez 2013 (table 1; Fe, U), Cordero 2008 (table 2).
constexpr std::array kPublished{
    PublishedRadius{"H", 1, 1.10, 0.31},   PublishedRadius{"C", 6, 1.70, 0.76},   PublishedRadius{"N", 7, 1.55, 0.71},
    PublishedRadius{"O", 8, 1.52, 0.66},   PublishedRadius{"Na", 11, 2.27, 1.66}, PublishedRadius{"Cl", 17, 1.75, 1.02},
    PublishedRadius{"Fe", 26, 2.44, 1.32}, PublishedRadius{"U", 92, 2.71, 1.96},  PublishedRadius{"Cs", 55, 3.43, 2.44},
    PublishedRadius{"Rn", 86, 2.20, 1.50}, PublishedRadius{"Lu", 71, 2.74, 1.87}};

TEST(ElementRadii, EqualThePublishedTables) {
  for (const PublishedRadius& element : kPublished) {
    EXPECT_EQ(element_radius(ElementRadii::van_der_waals, element.symbol), element.van_der_waals) << element.symbol;
    EXPECT_EQ(element_radius(ElementRadii::covalent, element.symbol), element.covalent) << element.symbol;
    EXPECT_EQ(element_radius(ElementRadii::van_der_waals, element.number), element.van_der_waals) << element.symbol;
    EXPECT_EQ(element_radius(ElementRadii::covalent, element.number), element.covalent) << element.symbol;
  }
  EXPECT_EQ(element_radius(ElementRadii::covalent, "FE"), 1.32);
  EXPECT_EQ(element_radius(ElementRadii::covalent, "cl"), 1.02);
  EXPECT_EQ(element_radius(ElementRadii::van_der_waals, "D"), 1.10);
  EXPECT_EQ(element_radius(ElementRadii::van_der_waals, "Pm"), std::nullopt);  // Alvarez gives none
  EXPECT_EQ(element_radius(ElementRadii::covalent, "Cf"), std::nullopt);
  for (const char* word : {"", "X", "Foo", "CA1"})
    EXPECT_EQ(element_radius(ElementRadii::covalent, word), std::nullopt);
  for (const double number : {0.0, -1.0, 1.5, 100.0, 1e300, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(element_radius(ElementRadii::van_der_waals, number), std::nullopt) << number;
  }
}

TEST(ElementRadii, FindTheElementInTheNameOfAnAtom) {
  struct Named {
    const char* name;
    const char* residue;
    const char* element;
  };
  for (const Named& atom :
       {Named{"CA", "ALA", "C"}, Named{"CA", "CA", "CA"}, Named{"HW1", "SOL", "H"}, Named{"OW", "SOL", "O"},
        Named{"1HB2", "ALA", "H"}, Named{"NA", "NA", "NA"}, Named{"NA+", "NA+", "NA"}, Named{"Cl1", "LIG", "Cl"},
        Named{"CD", "PRO", "C"}, Named{"SOD", "SOD", "SOD"}, Named{"N", "N", "N"}, Named{"12", "SOL", ""}}) {
    EXPECT_EQ(element_of_atom(atom.name, atom.residue), atom.element) << atom.name << " " << atom.residue;
  }
}

// Returns particles with an attribute of words.
ParticleSet with_words(const std::string& name, const std::vector<std::string>& words) {
  ParticleSet set = particles_at(std::vector<glm::dvec3>(words.size(), glm::dvec3(0)));
  ParticleWords made{name, {}, Buffer<std::uint32_t>(words.size())};
  for (std::size_t i = 0; i < words.size(); ++i) {
    made.indices[i] = static_cast<std::uint32_t>(made.words.size());
    made.words.push_back(words[i]);
  }
  set.words.push_back(std::move(made));
  return set;
}

std::vector<float> radii_in(const ParticleSet& set, std::string_view name = "radius") {
  for (const ParticleAttribute& attribute : set.attributes) {
    if (attribute.name == name) return {attribute.values.begin(), attribute.values.end()};
  }
  return {};
}

TEST(ElementRadii, BecomeTheAttributeOfTheParticles) {
  const Context context;
  ParticleSet set = with_words("species", {"O", "Na+", "h", "O2-"});
  EXPECT_EQ(set_element_radii(set, ElementRadii::van_der_waals, 0.1, context).value_or(""), "species");
  EXPECT_EQ(radii_in(set), (std::vector<float>{0.152F, 0.227F, 0.11F, 0.152F}));
  // An attribute that the field takes the radii from is replaced.
  set.attributes.clear();
  set.attributes.push_back({"pscale", 1, Buffer<float>(4)});
  ASSERT_TRUE(set_element_radii(set, ElementRadii::covalent, 1, context));
  EXPECT_EQ(radii_in(set, "pscale"), (std::vector<float>{0.66F, 1.66F, 0.31F, 0.66F}));
  EXPECT_EQ(set.attributes.size(), 1U);
}

TEST(ElementRadii, AcceptAtomicNumbersAndNamesOfAtoms) {
  ParticleSet set = particles_at({glm::dvec3(0), glm::dvec3(1)});
  set.attributes.push_back({"element", 1, Buffer<float>(2)});
  set.attributes[0].values[0] = 26;
  set.attributes[0].values[1] = 1;
  EXPECT_EQ(set_element_radii(set, ElementRadii::covalent, 1, Context()).value_or(""), "element");
  EXPECT_EQ(radii_in(set), (std::vector<float>{1.32F, 0.31F}));
  ParticleSet named = with_words("name", {"CA", "CL", "HB1"});
  named.words.push_back({"residue", {"ALA", "CL"}, Buffer<std::uint32_t>(3)});
  for (std::uint32_t i = 0; i < 3; ++i) named.words[1].indices[i] = i == 1 ? 1 : 0;
  EXPECT_EQ(set_element_radii(named, ElementRadii::covalent, 1, Context()).value_or(""), "name");
  EXPECT_EQ(radii_in(named), (std::vector<float>{0.76F, 1.02F, 0.31F}));
}

TEST(ElementRadii, RefuseUnknownElements) {
  ParticleSet set = with_words("element", {"O", "Xx", "MW", "H"});
  const auto refused = set_element_radii(set, ElementRadii::covalent, 1, Context());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::input);
  EXPECT_EQ(refused.error().message,
            "test.ply: expected elements with a covalent radius in the attribute 'element', found 'Xx' at particle 1; "
            "2 of 4 particles have no such element");
  EXPECT_TRUE(radii_in(set).empty());
  ParticleSet without = particles_at({glm::dvec3(0)});
  EXPECT_EQ(set_element_radii(without, ElementRadii::covalent, 1, Context()).error().code, ErrorCode::input);
  ParticleSet none = particles_at({});
  EXPECT_TRUE(set_element_radii(none, ElementRadii::covalent, 1, Context()));
}

}  // namespace
}  // namespace isoextract::points
