#include "dem/facets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace wheel_twin::dem {
namespace {

Eigen::Vector3d closest_on_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                    const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a;
  const Eigen::Vector3d ac = c - a;
  const Eigen::Vector3d ap = p - a;
  const double d1 = ab.dot(ap);
  const double d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  const Eigen::Vector3d bp = p - b;
  const double d3 = ab.dot(bp);
  const double d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + (d1 / (d1 - d3)) * ab;
  const Eigen::Vector3d cp = p - c;
  const double d5 = ab.dot(cp);
  const double d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + (d2 / (d2 - d6)) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b);
  const double inverse = 1.0 / (va + vb + vc);
  return a + (vb * inverse) * ab + (vc * inverse) * ac;
}

Eigen::Vector3d closest_on_ring(const Facet& f, const Eigen::Vector3d& p) {
  const Eigen::Vector3d from_origin = p - f.a;
  const double height = from_origin.dot(f.b);
  Eigen::Vector3d radial = from_origin - height * f.b;
  const double radius = radial.norm();
  radial = radius > 0.0 ? Eigen::Vector3d(radial / radius) : f.b.unitOrthogonal();
  const double dr = f.r1 - f.r0;
  const double dh = f.h1 - f.h0;
  const double t = std::clamp(((radius - f.r0) * dr + (height - f.h0) * dh) / (dr * dr + dh * dh), 0.0, 1.0);
  return f.a + (f.h0 + t * dh) * f.b + (f.r0 + t * dr) * radial;
}

struct FacetMaker {
  const Wall& wall;
  std::vector<Facet>& facets;

  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(fmt::format("wall '{}': {}", wall.name, what));
  }
  void operator()(const HalfSpace& shape) const {
    const double length = shape.normal.norm();
    if (!(length > 0.0) || !std::isfinite(length)) refuse("the normal of the half-space has no direction");
    Facet facet;
    facet.kind = Facet::Kind::kHalfSpace;
    facets = {facet};
  }
  void operator()(const Revolved& shape) const {
    facets.clear();
    for (std::size_t k = 0; k + 1 < shape.profile.size(); ++k) {
      const auto& p = shape.profile[k];
      const auto& q = shape.profile[k + 1];
      if (!(p.x() >= 0.0 && q.x() >= 0.0)) refuse("a radius of the profile is negative");
      if (!((q - p).norm() > 0.0)) refuse("two points of the profile coincide");
      Facet facet;
      facet.kind = Facet::Kind::kRing;
      facet.r0 = p.x();
      facet.h0 = p.y();
      facet.r1 = q.x();
      facet.h1 = q.y();
      facets.push_back(facet);
    }
    if (facets.empty()) refuse("the profile has fewer than two points");
  }
  void operator()(const Mesh& mesh) const {
    facets.clear();
    if (mesh.triangles.empty()) refuse("the mesh has no triangles");
    for (const auto& triangle : mesh.triangles) {
      for (const auto corner : triangle) {
        if (corner >= mesh.vertices.size()) refuse(fmt::format("a triangle names vertex {}", corner));
        if (!mesh.vertices[corner].allFinite()) refuse(fmt::format("vertex {} is not finite", corner));
      }
      const Eigen::Vector3d u = mesh.vertices[triangle[1]] - mesh.vertices[triangle[0]];
      const Eigen::Vector3d v = mesh.vertices[triangle[2]] - mesh.vertices[triangle[0]];
      if (!(u.cross(v).norm() > 1e-12 * u.norm() * v.norm())) {
        refuse(fmt::format("triangle {} has no area", facets.size()));
      }
      Facet facet;
      facet.kind = Facet::Kind::kTriangle;
      facets.push_back(facet);
    }
  }
};

}  // namespace

ClosestPoint closest_point(const Facet& facet, const Eigen::Vector3d& p) {
  if (facet.kind == Facet::Kind::kHalfSpace) {
    const double distance = facet.b.dot(p - facet.a);
    return {p - distance * facet.b, facet.b, distance};
  }
  const Eigen::Vector3d point = facet.kind == Facet::Kind::kTriangle
                                    ? closest_on_triangle(p, facet.a, facet.b, facet.c)
                                    : closest_on_ring(facet, p);
  const Eigen::Vector3d away = p - point;
  const double distance = away.norm();
  return {point, distance > 0.0 ? Eigen::Vector3d(away / distance) : Eigen::Vector3d::UnitZ(), distance};
}

std::vector<Facet> make_facets(const Wall& wall) {
  std::vector<Facet> facets;
  std::visit(FacetMaker{wall, facets}, wall.shape);
  place_facets(wall, facets);
  return facets;
}

void place_facets(const Wall& wall, std::vector<Facet>& facets) {
  const Eigen::Matrix3d rotation = wall.pose.orientation.toRotationMatrix();
  const Eigen::Vector3d& origin = wall.pose.position;
  if (const auto* mesh = std::get_if<Mesh>(&wall.shape)) {
    for (std::size_t k = 0; k < facets.size(); ++k) {
      const auto& t = mesh->triangles[k];
      facets[k].a = origin + rotation * mesh->vertices[t[0]];
      facets[k].b = origin + rotation * mesh->vertices[t[1]];
      facets[k].c = origin + rotation * mesh->vertices[t[2]];
    }
    return;
  }
  const auto* plane = std::get_if<HalfSpace>(&wall.shape);
  const Eigen::Vector3d direction = plane != nullptr ? Eigen::Vector3d(rotation * plane->normal.normalized())
                                                     : Eigen::Vector3d(rotation.col(2));
  for (auto& facet : facets) {
    facet.a = origin;
    facet.b = direction;
    facet.c.setZero();
  }
}

void bounds_of(const Facet& facet, Eigen::Vector3d& low, Eigen::Vector3d& high) {
  switch (facet.kind) {
    case Facet::Kind::kHalfSpace:
      low.setConstant(-1e30);
      high.setConstant(1e30);
      break;
    case Facet::Kind::kTriangle:
      low = facet.a.cwiseMin(facet.b).cwiseMin(facet.c);
      high = facet.a.cwiseMax(facet.b).cwiseMax(facet.c);
      break;
    case Facet::Kind::kRing: {
      const double radius = std::max(facet.r0, facet.r1);
      const Eigen::Vector3d middle = facet.a + 0.5 * (facet.h0 + facet.h1) * facet.b;
      const Eigen::Vector3d half =
          0.5 * std::fabs(facet.h1 - facet.h0) * facet.b.cwiseAbs() + Eigen::Vector3d::Constant(radius);
      low = middle - half;
      high = middle + half;
      break;
    }
  }
}

}  // namespace wheel_twin::dem
