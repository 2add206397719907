// Random combinations of solids, with a judge that knows of no rays: whether a point is inside.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "support/kernel/double_point.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render::csg_test {

using test::Point;

class RandomTree {
 public:
  /// A tree of up to `depth` groups within one another, cut off by the box from -2 to 2.
  RandomTree(unsigned seed, int depth) : random_(seed) {
    v1::Csg& csg = *shape_.mutable_csg();
    csg.set_operation(v1::Csg::INTERSECTION);
    root_.operation = v1::Csg::INTERSECTION;
    v1::Box& box = *csg.add_parts()->mutable_solid()->mutable_box();
    for (int i = 0; i < 3; ++i) box.add_low(-2), box.add_high(2);
    root_.operands.push_back({v1::Csg::UNION, {}, [](Point p) {
                                return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) < 2;
                              }});
    root_.operands.push_back(group(csg, depth));
  }
  const v1::Shape& shape() const { return shape_; }
  bool inside(Point p) const { return inside(root_, p); }
  double number(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Point direction() {
    for (;;) {
      const Point p{number(-1, 1), number(-1, 1), number(-1, 1)};
      if (test::length(p) < 1 && test::length(p) > 0.1) return test::unit(p);
    }
  }

 private:
  struct Node {
    v1::Csg::Operation operation = v1::Csg::UNION;
    std::vector<Node> operands;
    std::function<bool(Point)> solid;  // only where there are no operands
  };

  static bool inside(const Node& node, Point p) {
    if (node.solid) return node.solid(p);
    int within = 0;
    for (const Node& operand : node.operands) within += inside(operand, p);
    if (node.operation == v1::Csg::UNION) return within > 0;
    if (node.operation == v1::Csg::INTERSECTION) return within == static_cast<int>(node.operands.size());
    return within == 1 && inside(node.operands.front(), p);
  }

  Node group(v1::Csg& csg, int depth) {
    Node node;
    node.operation = static_cast<v1::Csg::Operation>(random_() % 3);
    v1::Csg::Part* begin = csg.add_parts();
    begin->mutable_begin()->set_operation(node.operation);
    const int count = 1 + static_cast<int>(random_() % (node.operation == v1::Csg::INTERSECTION ? 2 : 6));
    for (int i = 0; i < count; ++i)
      node.operands.push_back(depth > 1 && random_() % 2 == 0 ? group(csg, depth - 1) : solid(csg));
    csg.add_parts()->set_end(true);
    return node;
  }

  Node solid(v1::Csg& csg) {
    v1::Shape& shape = *csg.add_parts()->mutable_solid();
    // Turned, stretched, perhaps mirrored, moved.
    const Point x = direction(), y = test::unit(test::cross(x, direction())), z = test::cross(x, y);
    const double sx = number(0.4, 1.5), sy = number(0.4, 1.5),
                 sz = number(0.4, 1.5) * (random_() % 4 ? 1 : -1);
    const Point at{number(-1, 1), number(-1, 1), number(-1, 1)};
    for (const std::array<double, 4>& row : {std::array<double, 4>{x.x * sx, y.x * sy, z.x * sz, at.x},
                                             {x.y * sx, y.y * sy, z.y * sz, at.y},
                                             {x.z * sx, y.z * sy, z.z * sz, at.z},
                                             {0, 0, 0, 1}}) {
      for (const double e : row) shape.mutable_world_from_object()->add_elements(e);
    }
    const auto to_object = [=](Point p) {
      const Point q = p - at;
      return Point{test::dot(q, x) / sx, test::dot(q, y) / sy, test::dot(q, z) / sz};
    };
    Node node;
    const std::function<bool(Point)> formula = fill(shape);
    node.solid = [=](Point p) { return formula(to_object(p)); };
    return node;
  }

  /// The kind of a solid, and whether a point of its space is within.
  std::function<bool(Point)> fill(v1::Shape& shape) {
    switch (random_() % 10) {
      case 0:
        shape.mutable_sphere()->set_radius(0.75f);
        return [](Point p) { return test::dot(p, p) < 0.5625; };
      case 1:
        for (const float c : {-0.5f, -0.75f, -1.0f}) shape.mutable_box()->add_low(c);
        for (const float c : {0.5f, 0.25f, 1.0f}) shape.mutable_box()->add_high(c);
        return [](Point p) { return std::abs(p.x) < 0.5 && std::abs(p.y + 0.25) < 0.5 && std::abs(p.z) < 1; };
      case 2:
        shape.mutable_cylinder()->set_radius(0.5f);
        shape.mutable_cylinder()->set_z_min(-0.5f), shape.mutable_cylinder()->set_z_max(1);
        shape.mutable_cylinder()->set_capped(true);
        return [](Point p) { return p.z > -0.5 && p.z < 1 && std::hypot(p.x, p.y) < 0.5; };
      case 3:
        shape.mutable_cone()->set_radius(1), shape.mutable_cone()->set_height(1);
        shape.mutable_cone()->set_capped(true);
        return [](Point p) { return p.z > 0 && std::hypot(p.x, p.y) < 1 - p.z; };
      case 4:
        shape.mutable_torus()->set_major_radius(0.75f), shape.mutable_torus()->set_minor_radius(0.25f);
        return [](Point p) { return std::hypot(std::hypot(p.x, p.y) - 0.75, p.z) < 0.25; };
      case 5:
        for (const float r : {1.0f, 0.5f, 0.25f}) shape.mutable_ellipsoid()->add_radii(r);
        return [](Point p) { return std::hypot(p.x, p.y / 0.5, p.z / 0.25) < 1; };
      case 6:
        shape.mutable_half_space()->set_height(0.25f);
        return [](Point p) { return p.z < 0.25; };
      case 7: {  // ends in the faces of its bounds
        v1::ImplicitSurface& saddle = *shape.mutable_implicit();
        saddle.set_expression("z - x*y");
        for (const auto set : {&v1::Point3::set_x, &v1::Point3::set_y, &v1::Point3::set_z}) {
          (saddle.mutable_box()->mutable_low()->*set)(-0.75);
          (saddle.mutable_box()->mutable_high()->*set)(0.75);
        }
        return [](Point p) {
          return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) < 0.75 && p.z < p.x * p.y;
        };
      }
      case 8:
        shape.mutable_implicit()->set_expression("0.3 - abs(sqrt(x^2 + y^2 + z^2) - 0.5)");
        shape.mutable_implicit()->mutable_ball()->set_radius(1);
        return [](Point p) { return test::length(p) < 1 && std::abs(test::length(p) - 0.5) > 0.3; };
      default:
        for (const float x : {1.0f, -1.0f}) {
          for (const float y : {1.0f, -1.0f}) {
            for (const float z : {1.0f, -1.0f}) {
              for (const float c : {x, y, z, 1.0f}) shape.mutable_polyhedron()->add_planes(c);
            }
          }
        }
        return [](Point p) { return std::abs(p.x) + std::abs(p.y) + std::abs(p.z) < 1; };
    }
  }

  std::mt19937 random_;
  v1::Shape shape_;
  Node root_;
};

}  // namespace tessera::render::csg_test
