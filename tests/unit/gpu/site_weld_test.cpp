// Feeds the weld by hand: with the captures that a GPU would make of a CPU mesh, in any order.
#include "gpu/detail/site_weld.hpp"

#include <algorithm>
#include <map>
#include <random>

#include "drawings.hpp"
#include "extract/asymptotic_decider.hpp"
#include "support/fields.hpp"
#include "support/hints.hpp"

namespace isoextract::gpu {
namespace {

constexpr glm::ivec3 kDims(17, 9, 18);  // some bricks own edges but have no cell
constexpr double kIso = 3.5;

// Bricks of 8x8x8 cells, and the captured triangles of the cells of each.
class HandMade {
 public:
  explicit HandMade(extract::Method method)
      : table_(extract::case_table(method)),
        field_(test::random_field<std::uint8_t>(kDims, 6, 8)),
        bricks_((kDims + 7) / 8) {
    extract::ExtractOptions options;
    options.method = method;
    options.iso = kIso;
    options.edge_keys = true;
    cpu_ = test::extract(field_, options).mesh;
    for (std::size_t v = 0; v < cpu_.edges.size(); ++v) positions_[cpu_.edges[v]] = cpu_.positions[v];
    for (glm::ivec3 b(0); b.z < bricks_.z; ++b.z) {
      for (b.y = 0; b.y < bricks_.y; ++b.y) {
        for (b.x = 0; b.x < bricks_.x; ++b.x) origins_.push_back(8 * b);
      }
    }
    for (const glm::ivec3& origin : origins_) cells_.push_back(draw(origin));
  }

  struct Vertex {
    glm::vec3 position;
    std::uint32_t key;  // without the site
  };
  using Cell = std::vector<Vertex>;  // three a triangle

  [[nodiscard]] const extract::CaseTable& table() const { return table_; }
  [[nodiscard]] const std::vector<glm::ivec3>& origins() const { return origins_; }
  [[nodiscard]] const mesh::Mesh& cpu() const { return cpu_; }
  [[nodiscard]] std::vector<std::vector<Cell>>& cells() { return cells_; }
  [[nodiscard]] std::uint64_t proxies() const { return proxies_; }

  [[nodiscard]] std::int32_t site(const glm::ivec3& p) const {
    const glm::ivec3 b = p / 8;
    return glm::all(glm::lessThan(b, bricks_)) ? b.x + bricks_.x * (b.y + bricks_.y * b.z) : -1;
  }
  [[nodiscard]] std::array<std::int32_t, 8> near(std::size_t s) const {
    std::array<std::int32_t, 8> sites;
    for (int n = 0; n < 8; ++n) sites[static_cast<std::size_t>(n)] = site(origins_[s] + 8 * extract::direction_step(n));
    return sites;
  }
  [[nodiscard]] SiteWeld weld() const {
    return {table_, origins_, [this](std::size_t s) { return near(s); },
            [this](const glm::ivec3& cell) { return variant(cell); }};
  }

  // Adds all sites in portions of random size and order; the cells within a portion are in random order, too.
  void add_shuffled(SiteWeld& weld, unsigned seed) const {
    std::mt19937 engine(seed);
    std::vector<std::uint32_t> order(origins_.size());
    for (std::uint32_t s = 0; s < order.size(); ++s) order[s] = s;
    std::ranges::shuffle(order, engine);
    for (std::size_t first = 0; first < order.size();) {
      const std::size_t count = std::min<std::size_t>(1 + engine() % order.size(), order.size() - first);
      const auto batch = std::span(order).subspan(first, count);
      std::vector<std::pair<std::uint32_t, const Cell*>> drawn;
      for (std::uint32_t k = 0; k < count; ++k) {
        for (const Cell& cell : cells_[batch[k]]) drawn.emplace_back(k, &cell);
      }
      std::ranges::shuffle(drawn, engine);
      add(weld, batch, drawn);
      first += count;
    }
  }

  void add_in_order(SiteWeld& weld) const {
    std::vector<std::uint32_t> batch(origins_.size());
    std::vector<std::pair<std::uint32_t, const Cell*>> drawn;
    for (std::uint32_t s = 0; s < batch.size(); ++s) {
      batch[s] = s;
      for (const Cell& cell : cells_[s]) drawn.emplace_back(s, &cell);
    }
    add(weld, batch, drawn);
  }

  static void add(SiteWeld& weld, std::span<const std::uint32_t> batch,
                  const std::vector<std::pair<std::uint32_t, const Cell*>>& drawn) {
    std::vector<std::uint32_t> words;
    for (const auto& [site, cell] : drawn) {
      for (const Vertex& v : *cell) {
        for (int axis = 0; axis < 3; ++axis) words.push_back(std::bit_cast<std::uint32_t>(v.position[axis]));
        words.push_back(site << 16 | v.key);
      }
    }
    weld.add(batch, {words, 4});
  }

 private:
  [[nodiscard]] double value(const glm::ivec3& p) const {
    const auto& samples = std::get<field::DenseSamples>(field_.samples);
    return static_cast<const std::uint8_t*>(samples.data)[p.x + kDims.x * (p.y + kDims.y * p.z)];
  }
  [[nodiscard]] unsigned case_of(const glm::ivec3& cell) const {
    unsigned number = 0;
    for (int c = 0; c < 8; ++c) number |= (value(cell + extract::direction_step(c)) > kIso ? 1U : 0U) << c;
    return number;
  }
  [[nodiscard]] unsigned variant(const glm::ivec3& cell) const {
    return extract::cell_variant(table_, case_of(cell), {field::FieldKind::density, kIso},
                                 [&](int c) { return value(cell + extract::direction_step(c)); });
  }

  [[nodiscard]] std::vector<Cell> draw(const glm::ivec3& origin) {
    std::vector<Cell> cells;
    for (int number = 0; number < 512; ++number) {
      const glm::ivec3 low(number & 7, number >> 3 & 7, number >> 6);
      if (glm::any(glm::greaterThanEqual(origin + low, kDims - 1))) continue;
      const unsigned cell_case = case_of(origin + low);
      const unsigned first = table_.variants[cell_case];
      proxies_ += table_.ambiguous[cell_case] ? 1 : 0;
      Cell cell;
      for (int t = table_.first[first]; t < table_.first[first + 1]; ++t) {
        for (const std::uint8_t e : table_.triangles[static_cast<std::size_t>(t)]) {
          const extract::CellEdge& edge = table_.edges[e];
          const glm::ivec3 at = low + extract::direction_step(edge.corner);
          cell.push_back({positions_.at({origin + at, edge.direction}),
                          static_cast<std::uint32_t>((table_.ambiguous[cell_case] ? 1 : 0) << 15 |
                                                     edge.direction << 12 | at.z << 8 | at.y << 4 | at.x)});
        }
      }
      if (!cell.empty()) cells.push_back(std::move(cell));
    }
    return cells;
  }

  const extract::CaseTable& table_;
  field::ScalarField field_;
  glm::ivec3 bricks_;
  mesh::Mesh cpu_;
  std::map<mesh::EdgeKey, glm::vec3> positions_;
  std::vector<glm::ivec3> origins_;
  std::vector<std::vector<Cell>> cells_;  // by site
  std::uint64_t proxies_ = 0;
};

mesh::Mesh finished(SiteWeld& weld, bool mirrored = false) {
  const auto sizes = weld.number();
  if (!sizes) {
    ADD_FAILURE() << sizes.error().message;
    return {};
  }
  extract::ExtractOptions options;
  options.edge_keys = true;
  mesh::Mesh mesh;
  mesh.name = "test";
  extract::allocate_mesh(mesh, *sizes, {}, options);
  weld.write(mesh, mirrored);
  return mesh;
}

class Weld : public testing::TestWithParam<extract::Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, Weld, testing::Values(extract::Method::mc, extract::Method::mt), test::method_name);

TEST_P(Weld, EqualsCpuMesh) {
  const HandMade made(GetParam());
  SiteWeld weld = made.weld();
  made.add_in_order(weld);
  const mesh::Mesh mesh = finished(weld);
  test::expect_same_surface(made.cpu(), mesh);
  EXPECT_EQ(weld.decided_cells(), made.proxies());
  EXPECT_EQ(made.proxies() > 0, GetParam() == extract::Method::mc);
  for (std::size_t v = 0; v < mesh.edges.size(); ++v) {
    const auto site = static_cast<std::size_t>(made.site(mesh.edges[v].low));
    EXPECT_EQ(
        weld.vertex_at(site, mesh.edges[v].direction, field::block_offset(mesh.edges[v].low - made.origins()[site])),
        v);
  }
}

TEST_P(Weld, IgnoresOrderAndPortions) {
  const HandMade made(GetParam());
  SiteWeld in_order = made.weld();
  made.add_in_order(in_order);
  const mesh::Mesh expected = finished(in_order);
  for (unsigned seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    SiteWeld weld = made.weld();
    made.add_shuffled(weld, seed);
    test::expect_same_bytes(expected, finished(weld));
  }
}

TEST_P(Weld, ReversesWindingForMirrors) {
  const HandMade made(GetParam());
  SiteWeld weld = made.weld();
  made.add_in_order(weld);
  SiteWeld turned = made.weld();
  made.add_in_order(turned);
  const mesh::Mesh a = finished(weld);
  const mesh::Mesh b = finished(turned, true);
  ASSERT_EQ(a.triangles.size(), b.triangles.size());
  for (std::size_t t = 0; t < a.triangles.size(); ++t) {
    EXPECT_EQ(b.triangles[t], glm::uvec3(a.triangles[t].x, a.triangles[t].z, a.triangles[t].y));
  }
}

TEST_P(Weld, RefusesInvalidCaptures) {
  const auto expect_refused = [](SiteWeld& weld, const char* what) {
    const auto sizes = weld.number();
    ASSERT_FALSE(sizes) << what;
    EXPECT_EQ(sizes.error().code, ErrorCode::unavailable);
    EXPECT_TRUE(test::has_step(sizes.error().hint, Remedy::report, Setting::devices));
  };
  const HandMade made(GetParam());
  {
    // An edge whose owner is not a site.
    SiteWeld weld(
        made.table(), made.origins(),
        [&](std::size_t s) {
          auto near = made.near(s);
          near[1] = -1;
          return near;
        },
        [](const glm::ivec3&) { return 0U; });
    made.add_in_order(weld);
    expect_refused(weld, "no owner");
  }
  HandMade broken(GetParam());
  auto& cells = broken.cells()[0];
  // An unambiguous cell, so that the weld uses the key itself.
  const auto plain = std::ranges::find_if(cells, [](const auto& cell) { return (cell[0].key >> 15) == 0; });
  ASSERT_TRUE(plain != cells.end());
  const std::uint32_t key = (*plain)[0].key;
  {
    (*plain)[0].key = key & ~(7U << 12);
    SiteWeld weld = broken.weld();
    broken.add_in_order(weld);
    expect_refused(weld, "an edge without direction");
    (*plain)[0].key = key;
  }
  {
    // A site outside the batch.
    SiteWeld weld = broken.weld();
    const std::vector<std::uint32_t> batch{0};
    HandMade::add(weld, batch, {{0U, &*plain}, {1U, &*plain}});
    expect_refused(weld, "a stranger");
  }
  if (GetParam() == extract::Method::mt) return;
  // An ambiguous cell without the vertices that its variant needs.
  for (auto& cell : cells) {
    if ((cell[0].key >> 15) != 0 && cell.size() > 3) {
      cell.resize(3);
      break;
    }
  }
  SiteWeld weld = broken.weld();
  broken.add_in_order(weld);
  expect_refused(weld, "an incomplete proxy");
}

}  // namespace
}  // namespace isoextract::gpu
