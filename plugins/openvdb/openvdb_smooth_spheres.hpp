// The smooth surface of spheres: the distance from a sphere of averaged radius around averaged positions.
//
// Y. Zhu and R. Bridson, "Animating sand as a fluid", SIGGRAPH 2005, section 5: phi(x) = |x - a(x)| - f r(x). The means
// a(x) and r(x) of position and radius weigh nearby particles by (1 - (|x - x_i| / R_i)^2)^3. The reach R_i is the
// search radius, and at least twice the particle's radius, so that it covers the sphere. Between particles that are far
// apart, a(x) lies where no particle is, so that phi is negative there. Two steps remove such matter:
// - f shrinks where a(x) moves fast from one particle to another: B. Solenthaler, J. Schlaefli and R. Pajarola, "A
//   unified particle model for fluid-solid interactions", Computer Animation and Virtual Worlds 18(1), 2007. f falls
//   from 1 to 0 as the largest eigenvalue of the symmetric part of grad a rises from kUnhurried to kJump. The paper has
//   0.4 and 2, which also shrinks filled bodies, where the eigenvalue is about 1.
// - Bodies that contain no sample of any sphere become outside.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <openvdb/points/AttributeArray.h>
#include <openvdb/points/PointDataGrid.h>
#include <openvdb/points/PointTransfer.h>
#include <openvdb/tree/LeafManager.h>

#include "openvdb_parts.hpp"

namespace isoextract_openvdb {

constexpr double kUnhurried = 1.5;
constexpr double kJump = 3;

// Returns the reach R_i of a particle of this radius: the distance at which its weight becomes 0.
inline double smoothing_reach(double radius, double search_radius) { return std::max(search_radius, 2 * radius); }

// Returns the largest eigenvalue of a symmetric matrix (O. K. Smith, "Eigenvalues of a symmetric 3 x 3 matrix",
// Communications of the ACM 4(4), 1961). OpenVDB's Jacobi iteration returns NaN for some nearly diagonal matrices.
inline double largest_eigenvalue(const openvdb::Mat3d& a) {
  const double mean = a.trace() / 3;
  const openvdb::Mat3d rest = a - mean * openvdb::Mat3d::identity();
  double squares = 0;
  for (int row = 0; row < 3; ++row) squares += rest.row(row).lengthSqr();
  const double size = std::sqrt(squares / 6);
  if (!(size > 0)) return mean;
  const double angle = std::acos(std::clamp((rest * (1 / size)).det() / 2, -1.0, 1.0)) / 3;
  return mean + 2 * size * std::cos(angle);
}

// Sums over the particles near a sample, in voxels. The weight of a particle is w; the gradient of w is s times the
// offset from the sample to the particle.
struct NearbySums {
  double weight = 0;
  double radius = 0;               // of w r
  openvdb::Vec3d offset{0.0};      // of w times the offset
  openvdb::Vec3d slope{0.0};       // of s times the offset
  std::array<double, 6> spread{};  // of s times the offset's products xx, xy, xz, yy, yz, zz
  bool is_in_sphere = false;

  void add(const openvdb::Vec3d& away, double squared, double inverse_reach, double own_radius) {
    const double t = 1 - squared * inverse_reach;
    const double w = t * t * t;
    const openvdb::Vec3d scaled = 6 * t * t * inverse_reach * away;
    weight += w;
    radius += w * own_radius;
    offset += w * away;
    slope += scaled;
    spread[0] += scaled[0] * away[0];
    spread[1] += scaled[0] * away[1];
    spread[2] += scaled[0] * away[2];
    spread[3] += scaled[1] * away[1];
    spread[4] += scaled[1] * away[2];
    spread[5] += scaled[2] * away[2];
    is_in_sphere = is_in_sphere || squared < own_radius * own_radius;
  }

  // Returns the symmetric part of the gradient of the averaged position.
  [[nodiscard]] openvdb::Mat3d gradient() const {
    const openvdb::Vec3d mean = offset / weight;
    openvdb::Mat3d made;
    std::size_t product = 0;
    for (int row = 0; row < 3; ++row) {
      for (int column = row; column < 3; ++column) {
        const double mixed = (mean[row] * slope[column] + mean[column] * slope[row]) / 2;
        made(row, column) = made(column, row) = (spread[product++] - mixed) / weight;
      }
    }
    return made;
  }

  [[nodiscard]] double radius_factor() const {
    const openvdb::Mat3d slopes = gradient();
    double bound = 0;  // Gershgorin's, which spares most samples the eigenvalues
    for (int row = 0; row < 3; ++row) {
      double sum = slopes(row, row);
      for (int column = 0; column < 3; ++column) sum += column == row ? 0 : std::abs(slopes(row, column));
      bound = std::max(bound, sum);
    }
    if (bound <= kUnhurried) return 1;
    const double largest = largest_eigenvalue(slopes);
    const double g = std::clamp((kJump - largest) / (kJump - kUnhurried), 0.0, 1.0);
    return g * (g * (g - 3) + 3);
  }

  [[nodiscard]] double distance() const { return (offset / weight).length() - radius_factor() * radius / weight; }
};

// Computes the distances leaf by leaf, for openvdb::points::rasterize(). Only samples inside the surface but outside
// all spheres stay active. Points and distances share one transform.
class SmoothTransfer : public openvdb::points::VolumeTransfer<openvdb::FloatTree> {
 public:
  using Base = openvdb::points::VolumeTransfer<openvdb::FloatTree>;
  using PointLeaf = openvdb::points::PointDataTree::LeafNodeType;
  using Leaf = openvdb::FloatTree::LeafNodeType;
  using Mask = Leaf::NodeMaskType;

  // `longest_reach` is the largest reach of a particle, in world units.
  SmoothTransfer(openvdb::FloatGrid& surface, std::string radius, double search_radius, double longest_reach)
      : Base(surface.tree()),
        radius_name_(std::move(radius)),
        voxel_(surface.voxelSize()[0]),
        search_(search_radius / voxel_),
        longest_(longest_reach / voxel_),
        background_(surface.background()) {}
  // OpenVDB copies the transfer for each thread.
  SmoothTransfer(const SmoothTransfer& other)
      : Base(other),
        radius_name_(other.radius_name_),
        voxel_(other.voxel_),
        search_(other.search_),
        longest_(other.longest_),
        background_(other.background_) {}

  [[nodiscard]] openvdb::Int32 range(const openvdb::Coord& /*origin*/, std::size_t /*leaf*/) const {
    return static_cast<openvdb::Int32>(std::ceil(longest_));
  }

  void initialize(const openvdb::Coord& origin, std::size_t leaf, const openvdb::CoordBBox& bounds) {
    Base::initialize(origin, leaf, bounds);
    sums_.assign(kLeafValues, {});
  }

  // The names are OpenVDB's. NOLINTBEGIN(readability-identifier-naming)
  bool startPointLeaf(const PointLeaf& leaf) {
    positions_ = std::make_unique<PositionHandle>(leaf.constAttributeArray("P"));
    radii_ = std::make_unique<RadiusHandle>(leaf.constAttributeArray(radius_name_));
    return true;
  }

  void rasterizePoint(const openvdb::Coord& voxel, openvdb::Index id, const openvdb::CoordBBox& bounds) {
    const openvdb::Vec3d at = voxel.asVec3d() + openvdb::Vec3d(positions_->get(id));
    const double own_radius = static_cast<double>(radii_->get(id)) / voxel_;
    const double reach = smoothing_reach(own_radius, search_);
    const double inverse = 1 / (reach * reach);
    // Weights closer to 0 would lose all digits when the sums are divided by them.
    const double most = reach * reach * (1 - 1e-9);
    openvdb::CoordBBox box(openvdb::Coord::floor(at - reach), openvdb::Coord::ceil(at + reach));
    box.intersect(bounds);
    const openvdb::Coord& low = box.min();
    const openvdb::Coord& high = box.max();
    const Mask& active = *mask();
    for (int x = low.x(); x <= high.x(); ++x) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int z = low.z(); z <= high.z(); ++z) {
          const openvdb::Vec3d away = at - openvdb::Vec3d(x, y, z);
          const double squared = away.lengthSqr();
          if (squared >= most) continue;
          const openvdb::Index place = Leaf::coordToOffset({x, y, z});
          if (active.isOn(place)) sums_[place].add(away, squared, inverse, own_radius);
        }
      }
    }
  }

  bool endPointLeaf(const PointLeaf& /*leaf*/) { return true; }
  // NOLINTEND(readability-identifier-naming)

  bool finalize(const openvdb::Coord& /*origin*/, std::size_t /*leaf*/) {
    for (auto place = mask()->beginOn(); place; ++place) {
      const NearbySums& sums = sums_[place.pos()];
      float& value = buffer()[place.pos()];
      value = background_;
      if (sums.weight > 0) {
        value = std::clamp(static_cast<float>(sums.distance() * voxel_), -background_, background_);
      }
      if (value >= 0 || sums.is_in_sphere) mask()->setOff(place.pos());
    }
    return true;
  }

 private:
  using PositionHandle = openvdb::points::AttributeHandle<openvdb::Vec3f>;
  using RadiusHandle = openvdb::points::AttributeHandle<float>;

  std::string radius_name_;
  double voxel_;
  double search_;   // in voxels
  double longest_;  // in voxels
  float background_;
  std::unique_ptr<PositionHandle> positions_;  // of the current leaf of points
  std::unique_ptr<RadiusHandle> radii_;
  std::vector<NearbySums> sums_;  // of the current leaf of samples
};

// Activates all samples within reach of the particles. Returns the longest reach in world units.
inline double activate_reach(const openvdb::points::PointDataGrid& points, const std::string& radius,
                             double search_radius, openvdb::FloatGrid& surface) {
  const double voxel = surface.voxelSize()[0];
  double longest = search_radius;
  for (auto leaf = points.tree().cbeginLeaf(); leaf; ++leaf) {
    const openvdb::points::AttributeHandle<float> radii(leaf->constAttributeArray(radius));
    double reach = search_radius;
    for (openvdb::Index i = 0; i < radii.size(); ++i) {
      reach = std::max(reach, smoothing_reach(static_cast<double>(radii.get(i)), search_radius));
    }
    longest = std::max(longest, reach);
    openvdb::CoordBBox box;
    leaf->evalActiveBoundingBox(box);
    box.expand(static_cast<openvdb::Int32>(std::ceil(reach / voxel)) + 1);
    surface.tree().sparseFill(box, surface.background(), true);
  }
  surface.tree().voxelizeActiveTiles();
  return longest;
}

// Finds the bodies without a sample in a sphere. Samples in spheres are founded, as are inside samples next to a
// founded one; the other inside samples are in doubt.
class UnfoundedBodies {
 public:
  using Tree = openvdb::FloatTree;
  using Leaf = Tree::LeafNodeType;
  using Mask = Leaf::NodeMaskType;

  // Expects a tree in which only the samples inside the surface but outside all spheres are active.
  explicit UnfoundedBodies(Tree& tree) : tree_(tree), leaves_(tree), in_doubt_(leaves_.leafCount()) {}

  // Negates the values of these bodies' samples, which puts them outside.
  void remove(HostInterrupter& interrupter) {
    std::atomic<bool> is_changed = true;
    while (is_changed) {
      interrupter.check();
      is_changed = false;
      leaves_.foreach ([&](const Leaf& leaf, std::size_t n) {
        in_doubt_[n] = leaf.getValueMask();
        if (!leaf.getValueMask().isOff() && clear_doubts(leaf, in_doubt_[n])) is_changed = true;
      });
      leaves_.foreach ([&](Leaf& leaf, std::size_t n) { leaf.setValueMask(in_doubt_[n]); });
    }
    leaves_.foreach ([&](Leaf& leaf, std::size_t n) {
      for (auto place = in_doubt_[n].beginOn(); place; ++place) {
        leaf.setValueOnly(place.pos(), -leaf.getValue(place.pos()));
      }
    });
  }

 private:
  // Clears the doubts of samples connected to founded ones in this leaf and, from the last pass, in neighbor leaves.
  // Returns whether it cleared any.
  bool clear_doubts(const Leaf& leaf, Mask& doubts) const {
    bool is_any = false;
    for (bool is_changed = true; is_changed;) {
      is_changed = false;
      for (auto place = doubts.beginOn(); place; ++place) {
        if (!has_founded_neighbor(leaf, doubts, place.pos())) continue;
        doubts.setOff(place.pos());
        is_changed = is_any = true;
      }
    }
    return is_any;
  }

  [[nodiscard]] bool has_founded_neighbor(const Leaf& leaf, const Mask& doubts, openvdb::Index place) const {
    const openvdb::Coord at = leaf.offsetToGlobalCoord(place);
    for (int axis = 0; axis < 3; ++axis) {
      for (const int step : {-1, 1}) {
        openvdb::Coord next = at;
        next[axis] += step;
        const openvdb::Index there = Leaf::coordToOffset(next);
        if ((next & ~(static_cast<openvdb::Int32>(Leaf::DIM) - 1)) == leaf.origin()) {
          if (leaf.getValue(there) < 0 && !doubts.isOn(there)) return true;
          continue;
        }
        const Leaf* const neighbor = tree_.probeConstLeaf(next);
        if (neighbor != nullptr && neighbor->getValue(there) < 0 && !neighbor->isValueOn(there)) return true;
      }
    }
    return false;
  }

  Tree& tree_;
  openvdb::tree::LeafManager<Tree> leaves_;
  std::vector<Mask> in_doubt_;  // for each leaf
};

// Returns the level set of the surface, with the transform of the points. Their attribute named `radius` and
// `search_radius` are in world units, `half_band` is in voxels. Throws PluginError if the host cancels.
inline openvdb::FloatGrid::Ptr smooth_surface(const openvdb::points::PointDataGrid& points, const std::string& radius,
                                              double search_radius, double half_band, HostInterrupter& interrupter) {
  const auto background = static_cast<float>(half_band * points.voxelSize()[0]);
  auto surface = openvdb::FloatGrid::create(background);
  surface->setTransform(points.transform().copy());
  surface->setGridClass(openvdb::GRID_LEVEL_SET);
  const double longest_reach = activate_reach(points, radius, search_radius, *surface);
  interrupter.check();
  SmoothTransfer transfer(*surface, radius, search_radius, longest_reach);
  openvdb::points::rasterize<openvdb::points::PointDataGrid, SmoothTransfer, openvdb::points::NullFilter,
                             openvdb::util::NullInterrupter>(points, transfer, openvdb::points::NullFilter(),
                                                             &interrupter);
  interrupter.check();
  UnfoundedBodies(surface->tree()).remove(interrupter);
  openvdb::tree::LeafManager<openvdb::FloatTree> leaves(surface->tree());
  leaves.foreach ([background](openvdb::FloatTree::LeafNodeType& leaf, std::size_t /*n*/) {
    for (openvdb::Index i = 0; i < kLeafValues; ++i) leaf.setActiveState(i, std::abs(leaf.getValue(i)) < background);
  });
  return surface;
}

}  // namespace isoextract_openvdb
