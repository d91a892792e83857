#include "gpu/detail/site_weld.hpp"

#include <algorithm>
#include <atomic>
#include <numeric>

#include <tbb/enumerable_thread_specific.h>

#include "base/parallel.hpp"
#include "base/stopwatch.hpp"

namespace isoextract::gpu {
namespace {

constexpr std::uint32_t kDecidedLater = 1U << 15;
constexpr std::size_t kSitesPerPiece = 64;

glm::ivec3 low_of(std::uint32_t key) { return glm::ivec3(key & 15U, key >> 4 & 15U, key >> 8 & 15U); }
unsigned direction_of(std::uint32_t key) { return key >> 12 & 7U; }

std::uint16_t local_key(const glm::ivec3& low, unsigned direction) {
  return static_cast<std::uint16_t>(direction << 12 | static_cast<unsigned>(low.z << 8 | low.y << 4 | low.x));
}

// Returns the cell of a triangle. No triangle lies in a cell face, so it touches both sides of its cell along each
// axis. The cell is thus the minimum of the lower ends of its edges.
glm::ivec3 cell_of(const CapturedSoup& soup, std::size_t triangle) {
  return glm::min(glm::min(low_of(soup.key(3 * triangle)), low_of(soup.key(3 * triangle + 1))),
                  low_of(soup.key(3 * triangle + 2)));
}

int cell_number(const glm::ivec3& cell) { return cell.x | cell.y << 3 | cell.z << 6; }

template <class F>
void for_each_site(std::size_t count, const F& f) {
  for_each_index(count, f, kSitesPerPiece);
}

}  // namespace

// Maps local keys to the vertex numbers of a site.
class SiteWeld::LocalVertices {
 public:
  static constexpr std::uint16_t kNone = 0xFFFF;
  LocalVertices() : numbers_(1U << 15, kNone) {}

  [[nodiscard]] std::uint16_t find(std::uint16_t key) const { return numbers_[key]; }
  void set(std::uint16_t key, std::uint16_t number) { numbers_[key] = number; }
  void forget(std::span<const std::uint16_t> keys) {
    for (const std::uint16_t key : keys) numbers_[key] = kNone;
  }

 private:
  std::vector<std::uint16_t> numbers_;
};

SiteWeld::SiteWeld(const extract::CaseTable& table, std::span<const glm::ivec3> sites, NearSites near,
                   DecideCell decide)
    : table_(table), sites_(sites), near_(std::move(near)), decide_(std::move(decide)), ranges_(sites.size()) {}

void SiteWeld::add(std::span<const std::uint32_t> batch, const CapturedSoup& soup) {
  const Stopwatch watch;
  const std::size_t count = soup.vertices() / 3;
  const auto site_of = [&](std::uint32_t triangle) { return soup.key(std::size_t{3} * triangle) >> 16; };
  std::vector<std::uint32_t> triangles(count);
  std::iota(triangles.begin(), triangles.end(), 0U);
  // Drivers keep the order of patches and vertices; the sort makes sure.
  if (!std::ranges::is_sorted(triangles, {}, site_of)) std::ranges::stable_sort(triangles, {}, site_of);

  has_unknown_sites_ = has_unknown_sites_ || (count > 0 && site_of(triangles.back()) >= batch.size());

  const std::size_t pieces = (batch.size() + kSitesPerPiece - 1) / kSitesPerPiece;
  const std::size_t first_piece = pieces_.size();
  pieces_.resize(first_piece + pieces);
  tbb::enumerable_thread_specific<LocalVertices> scratch;
  for_each_index(pieces, [&](std::size_t p) {
    Piece& piece = pieces_[first_piece + p];
    LocalVertices& local = scratch.local();
    const std::size_t begin = p * kSitesPerPiece;
    const std::size_t end = std::min(begin + kSitesPerPiece, batch.size());
    auto next = std::ranges::lower_bound(triangles, static_cast<std::uint32_t>(begin), {}, site_of);
    for (std::size_t k = begin; k < end; ++k) {
      const auto first = next;
      while (next != triangles.end() && site_of(*next) == k) ++next;
      SiteRange& range = ranges_[batch[k]];
      range.piece = static_cast<std::uint32_t>(first_piece + p);
      range.first_vertex = static_cast<std::uint32_t>(piece.keys.size());
      range.first_triangle = static_cast<std::uint32_t>(piece.triangles.size());
      if (first != next) weld_site(batch[k], soup, {first, next}, local, piece);
      range.vertices = static_cast<std::uint32_t>(piece.keys.size()) - range.first_vertex;
      range.triangles = static_cast<std::uint32_t>(piece.triangles.size()) - range.first_triangle;
    }
  });
  for (std::size_t p = first_piece; p < pieces_.size(); ++p) piece_bytes_ += pieces_[p].bytes();
  time_ += watch.elapsed();
}

std::uint64_t SiteWeld::Piece::bytes() const {
  return keys.capacity() * sizeof(keys[0]) + (positions.capacity() + normals.capacity()) * sizeof(glm::vec3) +
         triangles.capacity() * sizeof(triangles[0]);
}

void SiteWeld::weld_site(std::uint32_t site, const CapturedSoup& soup, std::span<const std::uint32_t> triangles,
                         LocalVertices& local, Piece& piece) {
  const std::size_t first = piece.keys.size();
  const bool normals = soup.stride > 4;
  const auto vertex = [&](std::size_t v) {
    const auto key = static_cast<std::uint16_t>(soup.key(v) & (kDecidedLater - 1));
    std::uint16_t number = local.find(key);
    if (number != LocalVertices::kNone) return number;
    number = static_cast<std::uint16_t>(piece.keys.size() - first);
    local.set(key, number);
    piece.keys.push_back(key);
    piece.positions.push_back(soup.position(v));
    if (normals) piece.normals.push_back(soup.normal(v));
    return number;
  };

  // Sorted by cell; the triangles of a cell keep their order.
  std::vector<std::pair<int, std::uint32_t>> by_cell;
  by_cell.reserve(triangles.size());
  for (const std::uint32_t t : triangles) by_cell.emplace_back(cell_number(cell_of(soup, t)), t);
  if (!std::ranges::is_sorted(by_cell, {}, &std::pair<int, std::uint32_t>::first)) {
    std::ranges::stable_sort(by_cell, {}, &std::pair<int, std::uint32_t>::first);
  }
  for (std::size_t at = 0; at < by_cell.size();) {
    const auto [cell, t] = by_cell[at];
    if ((soup.key(std::size_t{3} * t) & kDecidedLater) == 0) {
      piece.triangles.push_back(
          {vertex(std::size_t{3} * t), vertex(std::size_t{3} * t + 1), vertex(std::size_t{3} * t + 2)});
      ++at;
      continue;
    }
    // A marked cell brings only its vertices; the decider chooses the triangles.
    for (; at < by_cell.size() && by_cell[at].first == cell; ++at) {
      for (std::size_t v = 0; v < 3; ++v) vertex(std::size_t{3} * by_cell[at].second + v);
    }
    const glm::ivec3 low(cell & 7, cell >> 3 & 7, cell >> 6);
    const unsigned variant = decide_(sites_[site] + low);
    ++piece.decided;
    for (int drawn = table_.first[variant]; drawn < table_.first[variant + 1]; ++drawn) {
      std::array<std::uint16_t, 3> corners;
      for (std::size_t v = 0; v < 3; ++v) {
        const extract::CellEdge& edge = table_.edges[table_.triangles[static_cast<std::size_t>(drawn)][v]];
        corners[v] = local.find(local_key(low + extract::direction_step(edge.corner), edge.direction));
        if (corners[v] == LocalVertices::kNone) piece.incomplete = true;
      }
      piece.triangles.push_back(corners);
    }
  }
  local.forget(std::span(piece.keys).subspan(first));
}

SiteWeld::EdgeOwner SiteWeld::owner_of(const std::array<std::int32_t, 8>& near, std::uint16_t key) const {
  const glm::ivec3 low = low_of(key);
  const auto place = static_cast<std::size_t>(low.x >> 3 | low.y >> 3 << 1 | low.z >> 3 << 2);
  return {near[place], static_cast<std::uint32_t>(table_.index_of(static_cast<int>(direction_of(key)))),
          field::block_offset(low)};
}

Result<extract::MeshSizes> SiteWeld::number() {
  const Stopwatch watch;
  vertices_ = extract::SiteVertices(sites_.size(), table_.directions.size());
  const auto each_vertex = [&](std::size_t site, const auto& f) {
    const SiteRange& range = ranges_[site];
    if (range.vertices == 0) return;
    const Piece& piece = pieces_[range.piece];
    const auto near = near_(site);
    for (std::uint32_t v = range.first_vertex; v < range.first_vertex + range.vertices; ++v) {
      f(v, owner_of(near, piece.keys[v]));
    }
  };
  const auto mark = [&](const EdgeOwner& owner) {
    vertices_.crossed(static_cast<std::size_t>(owner.site),
                      owner.direction)[static_cast<std::size_t>(owner.offset >> 6)] |= std::uint64_t{1}
                                                                                       << (owner.offset & 63);
  };
  const auto known = [&](const EdgeOwner& owner) {
    return vertices_.is_crossed(static_cast<std::size_t>(owner.site), owner.direction, owner.offset);
  };
  // Marks the edges that their own site captured, in parallel; then, in order, the edges that only other sites
  // captured.
  for_each_site(sites_.size(), [&](std::size_t site) {
    each_vertex(site, [&](std::uint32_t, const EdgeOwner& owner) {
      if (owner.site == static_cast<std::int32_t>(site)) mark(owner);
    });
  });
  tbb::enumerable_thread_specific<std::vector<BorrowedVertex>> late;
  std::atomic<bool> sound{!has_unknown_sites_ && std::ranges::none_of(pieces_, &Piece::incomplete)};
  for_each_site(sites_.size(), [&](std::size_t site) {
    each_vertex(site, [&](std::uint32_t vertex, const EdgeOwner& owner) {
      if (owner.site < 0 || owner.direction >= table_.directions.size()) {
        sound = false;
      } else if (!known(owner)) {
        late.local().push_back({static_cast<std::uint32_t>(site), vertex, owner});
      }
    });
  });
  if (!sound) {
    return fail(ErrorCode::unavailable,
                "the GPU returned invalid triangles: they do not match the cells and edges of the grid",
                {{Remedy::report, Setting::devices}, {Remedy::use, Setting::cpu_backend}});
  }
  for (const auto& part : late) borrowed_vertices_.insert(borrowed_vertices_.end(), part.begin(), part.end());
  std::ranges::sort(borrowed_vertices_, {}, [](const BorrowedVertex& v) { return std::pair(v.site, v.vertex); });
  std::vector<BorrowedVertex> first_of_each;
  for (const BorrowedVertex& v : borrowed_vertices_) {
    if (known(v.owner)) continue;
    mark(v.owner);
    first_of_each.push_back(v);
  }
  borrowed_vertices_ = std::move(first_of_each);
  for_each_site(sites_.size(), [&](std::size_t site) { vertices_.count(site); });

  extract::MeshSizes sizes;
  sizes.vertices = vertices_.number();
  first_triangle_.resize(sites_.size());
  for (std::size_t site = 0; site < sites_.size(); ++site) {
    first_triangle_[site] = sizes.triangles;
    sizes.triangles += ranges_[site].triangles;
  }
  for (const Piece& piece : pieces_) decided_cells_ += piece.decided;
  time_ += watch.elapsed();
  return sizes;
}

void SiteWeld::write(mesh::Mesh& mesh, bool mirrored) const {
  const auto put = [&](std::size_t number, std::size_t site, std::uint32_t vertex) {
    const Piece& piece = pieces_[ranges_[site].piece];
    mesh.positions[number] = piece.positions[vertex];
    if (!mesh.normals.empty()) mesh.normals[number] = piece.normals[vertex];
    if (mesh.edges.empty()) return;
    const std::uint16_t key = piece.keys[vertex];
    mesh.edges[number] = {sites_[site] + low_of(key), static_cast<std::int32_t>(direction_of(key))};
  };
  for_each_site(sites_.size(), [&](std::size_t site) {
    const SiteRange& range = ranges_[site];
    if (range.vertices == 0) return;
    const Piece& piece = pieces_[range.piece];
    const auto near = near_(site);
    std::vector<std::uint32_t> numbers(range.vertices);
    for (std::uint32_t v = 0; v < range.vertices; ++v) {
      const EdgeOwner owner = owner_of(near, piece.keys[range.first_vertex + v]);
      numbers[v] = vertices_.at(static_cast<std::size_t>(owner.site), owner.direction, owner.offset);
      if (owner.site == static_cast<std::int32_t>(site)) put(numbers[v], site, range.first_vertex + v);
    }
    glm::uvec3* out = mesh.triangles.data() + first_triangle_[site];
    for (std::uint32_t t = range.first_triangle; t < range.first_triangle + range.triangles; ++t) {
      const auto& corners = piece.triangles[t];
      const glm::uvec3 triangle(numbers[corners[0]], numbers[corners[1]], numbers[corners[2]]);
      *out++ = mirrored ? glm::uvec3(triangle.x, triangle.z, triangle.y) : triangle;
    }
  });
  for (const BorrowedVertex& v : borrowed_vertices_) {
    put(vertices_.at(static_cast<std::size_t>(v.owner.site), v.owner.direction, v.owner.offset), v.site, v.vertex);
  }
}

std::uint32_t SiteWeld::vertex_at(std::size_t site, int direction, int offset) const {
  return vertices_.at(site, table_.index_of(direction), offset);
}

}  // namespace isoextract::gpu
