#include "dem/clump_template.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "base/random.h"

namespace wheel_twin::dem {
namespace {

constexpr double pi = 3.14159265358979323846;

double ball(double r) {
  return 4.0 / 3.0 * pi * r * r * r;
}

void expect_near(const VolumeMoments& a, const VolumeMoments& b, double relative) {
  const double size = std::cbrt(b.volume);
  EXPECT_NEAR(a.volume, b.volume, relative * b.volume);
  EXPECT_LT((a.centroid - b.centroid).norm(), relative * size);
  EXPECT_LT((a.inertia - b.inertia).norm(), relative * b.inertia.norm());
}

std::vector<ClumpSphere> turned(std::vector<ClumpSphere> spheres, const Eigen::Quaterniond& q) {
  for (ClumpSphere& sphere : spheres) sphere.center = q * sphere.center;
  return spheres;
}

const std::vector<ClumpSphere> tetrahedron = {
    {{1.0, 1.0, 1.0}, 1.5}, {{1.0, -1.0, -1.0}, 1.4}, {{-1.0, 1.0, -1.0}, 1.3}, {{-1.0, -1.0, 1.0}, 1.6}};

TEST(UnionMoments, OneSphere) {
  const VolumeMoments m = union_by_slices({{{0.3, -0.2, 0.7}, 2.0}});
  EXPECT_NEAR(m.volume, ball(2.0), 1e-12 * ball(2.0));
  EXPECT_LT((m.centroid - Eigen::Vector3d(0.3, -0.2, 0.7)).norm(), 1e-12);
  EXPECT_LT((m.inertia - 0.4 * ball(2.0) * 4.0 * Eigen::Matrix3d::Identity()).norm(),
            1e-10 * m.inertia.norm());
}

TEST(UnionMoments, DisjointSpheresAdd) {
  const ClumpSphere a{{1.0, 0.0, 0.0}, 0.5};
  const ClumpSphere b{{-2.0, 0.5, 1.0}, 1.0};
  VolumeMoments sum;
  sum.volume = ball(0.5) + ball(1.0);
  sum.centroid = (ball(0.5) * a.center + ball(1.0) * b.center) / sum.volume;
  for (const ClumpSphere& s : {a, b}) {
    const Eigen::Vector3d d = s.center - sum.centroid;
    sum.inertia +=
        ball(s.radius) *
        ((0.4 * s.radius * s.radius + d.squaredNorm()) * Eigen::Matrix3d::Identity() - d * d.transpose());
  }
  expect_near(union_of_two(a, b), sum, 1e-13);
  expect_near(union_by_slices({a, b}), sum, 1e-12);
}

TEST(UnionMoments, SphereInsideAnotherAddsNothing) {
  const ClumpSphere big{{0.1, 0.2, 0.3}, 1.0};
  const ClumpSphere small{{0.2, 0.2, 0.3}, 0.5};
  const VolumeMoments one = union_by_slices({big});
  expect_near(union_of_two(big, small), one, 1e-13);
  expect_near(union_of_two(small, big), one, 1e-13);
  expect_near(union_of_two(big, big), one, 1e-13);
  expect_near(union_by_slices({big, small, big}), one, 1e-12);
}

// Lens of two equal spheres at distance d: pi (4 r + d)(2 r - d)^2 / 12 (Weisstein, "Sphere-Sphere
// Intersection").
TEST(UnionMoments, VolumeLosesTheLens) {
  for (const double d : {0.2, 0.86, 1.5}) {
    const double lens = pi * (4.0 + d) * (2.0 - d) * (2.0 - d) / 12.0;
    const VolumeMoments two = union_of_two({{0, 0, 0}, 1.0}, {{0, d, 0}, 1.0});
    EXPECT_NEAR(two.volume, 2.0 * ball(1.0) - lens, 1e-12);
    // A chain whose ends do not meet loses one lens a joint.
    if (d > 1.0) {
      const VolumeMoments chain = union_by_slices({{{0, 0, 0}, 1.0}, {{d, 0, 0}, 1.0}, {{2 * d, 0, 0}, 1.0}});
      EXPECT_NEAR(chain.volume, 3.0 * ball(1.0) - 2.0 * lens, 1e-11);
    }
  }
}

TEST(UnionMoments, SlicesAgreeWithTheClosedFormOfTwo) {
  Random random(7);
  for (int trial = 0; trial < 50; ++trial) {
    ClumpSphere a{{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)},
                  random.uniform(0.5, 1.0)};
    ClumpSphere b{{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)},
                  random.uniform(0.5, 1.0)};
    expect_near(union_by_slices({a, b}), union_of_two(a, b), 1e-10);
  }
}

// The slices lie across z, so turning the clump changes the quadrature but not the body.
TEST(UnionMoments, FourOverlappingSpheresDoNotDependOnTheAxes) {
  const VolumeMoments reference = union_by_slices(tetrahedron, 40);
  Random random(11);
  for (int trial = 0; trial < 10; ++trial) {
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
    VolumeMoments m = union_by_slices(turned(tetrahedron, q));
    const Eigen::Matrix3d r = q.toRotationMatrix();
    m.centroid = r.transpose() * m.centroid;
    m.inertia = r.transpose() * m.inertia * r;
    expect_near(m, reference, 1e-9);
  }
}

// Counting random points is independent of the quadrature; the tolerance is four standard errors.
TEST(UnionMoments, FourOverlappingSpheresAgreeWithRandomPoints) {
  Random random(5);
  const int count = 400000;
  const double edge = 3.0;
  int inside = 0;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p(random.uniform(-edge, edge), random.uniform(-edge, edge),
                            random.uniform(-edge, edge));
    for (const ClumpSphere& s : tetrahedron)
      if ((p - s.center).norm() < s.radius) {
        ++inside;
        break;
      }
  }
  const double box = 8.0 * edge * edge * edge;
  const double fraction = static_cast<double>(inside) / count;
  const double standard_error = box * std::sqrt(fraction * (1.0 - fraction) / count);
  EXPECT_NEAR(union_by_slices(tetrahedron).volume, box * fraction, 4.0 * standard_error);
}

TEST(UnionMoments, QuadratureConvergesExponentially) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(0.3, 0.5, -0.4, 0.7).normalized();
  const std::vector<ClumpSphere> spheres = turned(tetrahedron, q);
  const double exact = union_by_slices(spheres, 64).volume;
  const auto error = [&](int nodes) {
    return std::abs(union_by_slices(spheres, nodes).volume / exact - 1.0);
  };
  EXPECT_LT(error(4), 1e-2);
  EXPECT_LT(error(8), 1e-2 * error(4));
  EXPECT_LT(error(24), 1e-10);
}

TEST(ClumpTemplate, BodyFrameIsPrincipalAndCentred) {
  const ClumpTemplate clump = make_clump("tetrahedron", tetrahedron);
  const VolumeMoments m = union_by_slices(clump.spheres);
  EXPECT_LT(m.centroid.norm(), 1e-10);
  EXPECT_LT((m.inertia - Eigen::Matrix3d(clump.inertia.asDiagonal())).norm(), 1e-9 * m.inertia.norm());
  // Turning into the body frame keeps handedness: signed volume of the four centres.
  const auto handedness = [](const std::vector<ClumpSphere>& s) {
    Eigen::Matrix3d edges;
    for (int i = 0; i < 3; ++i) edges.col(i) = s[i + 1].center - s[0].center;
    return edges.determinant();
  };
  EXPECT_NEAR(handedness(clump.spheres), handedness(tetrahedron), 1e-9);
}

TEST(ClumpTemplate, RefusesWhatIsNotAClump) {
  EXPECT_THROW(make_clump("none", {}), Error);
  EXPECT_THROW(make_clump("apart", {{{0, 0, 0}, 1.0}, {{2.0, 0, 0}, 1.0}}), Error);
  EXPECT_THROW(make_clump("flat", {{{0, 0, 0}, 0.0}}), Error);
  EXPECT_THROW(make_clump("nan", {{{std::nan(""), 0, 0}, 1.0}}), Error);
  EXPECT_THROW(make_clump("many", std::vector<ClumpSphere>(17, {{0, 0, 0}, 1.0})), Error);
}

TEST(ClumpFamily, ReadsSharesAndSizes) {
  const ClumpFamily family = read_clump_family(yaml::parse_text(R"(
name: pair
sphere_radius: 0.003
size_range: [0.9, 1.1]
shapes:
  - name: ball
    share: 1
    spheres: [{center: [0, 0, 0], radius: 1}]
  - name: dumbbell
    share: 3
    spheres: [{center: [0, 0, 0], radius: 1}, {center: [1, 0, 0], radius: 0.5}]
)",
                                                                "test"));
  EXPECT_DOUBLE_EQ(family.shares[1], 0.75);
  EXPECT_NEAR(family.smallest_radius(), 0.9 * 0.0015, 1e-15);
  // Mean of s^3 over [0.9, 1.1] is 1.01.
  EXPECT_NEAR(family.mean_volume(), 1.01 * (0.25 * ball(0.003) + 0.75 * family.shapes[1].volume), 1e-18);
}

TEST(ClumpFamily, ErrorNamesTheFileAndTheClump) {
  try {
    read_clump_family(yaml::parse_text(R"(
name: broken
sphere_radius: 0.003
size_range: [1, 1]
shapes:
  - {name: apart, spheres: [{center: [0, 0, 0], radius: 1}, {center: [3, 0, 0], radius: 1}]}
)",
                                       "broken.yaml"));
    FAIL() << "a clump in two pieces was accepted";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("broken.yaml"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("apart"), std::string::npos);
  }
}

}  // namespace
}  // namespace wheel_twin::dem
