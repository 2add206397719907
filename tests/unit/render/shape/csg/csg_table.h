// A combination of solids as the kernels have it, from its message, and its borders along rays.
#pragma once

#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/scene/shape/shape_builder.h"
#include "render/shape/analytic_shape.h"
#include "support/kernel/double_point.h"
#include "unit/render/scene/builder_inputs.h"

namespace tessera::render::TESSERA_ISA::csg_test {

using test::Point;

/// A ray as kernels take it: of floats.
struct Ray {
  Point o, d;
  Ray(Point origin, Point direction) : o(rounded(origin)), d(rounded(direction)) {}
  Point at(double t) const { return o + d * t; }

  static Point rounded(Point p) {
    return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
  }
};

inline Vec3 lanes(Point p) {
  return {Float(static_cast<float>(p.x)), Float(static_cast<float>(p.y)), Float(static_cast<float>(p.z))};
}

using Blobs = std::map<std::string, std::string>;

/// Materials "m0" to "m9" are those of that number.
class CsgTable {
 public:
  /// `text`: a Shape. A failure of the test where it cannot be built; nothing is hit then.
  explicit CsgTable(const std::string& text, const Blobs& blobs = {}, const Transform& placed = {}) {
    v1::Shape shape;
    EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &shape)) << text;
    build(shape, blobs, placed);
  }
  explicit CsgTable(const v1::Shape& shape, const Transform& placed = {}) { build(shape, {}, placed); }

  bool is_there() const { return !table_.shapes.empty(); }
  const ShapeTable& table() const { return table_; }

  /// Ray parameters of all borders, in order.
  std::vector<float> borders(const Ray& ray) const {
    std::vector<float> found;
    if (!is_there()) return found;
    float t = 0;
    do {
      t = nearest(ray, t);
      if (t >= 0) found.push_back(t);
    } while (t >= 0 && found.size() < 10000);
    return found;
  }
  float nearest(const Ray& ray, float t_near = 0) const {
    const ShapeRays rays{lanes(ray.o), lanes(ray.d), Float(t_near), Float(__builtin_inff()), Mask::all()};
    return analytic_shape(ShapeKind::kCsg)->nearest(table_, table_.shapes[0], 0, rays).lane(3);
  }
  Surface surface(const Ray& ray, float t) const {
    const Hit hit{Float(t), Float(0.0f), Float(0.0f), Int(0), Int(0), Int(-1)};
    return surface_at(table_, hit, lanes(ray.o), lanes(ray.d), Mask::all(), true);
  }
  int material(const Ray& ray, float t) const { return surface(ray, t).material.lane(3); }

 private:
  void build(const v1::Shape& shape, const Blobs& in_memory, const Transform& placed) {
    const BlobsInMemory blobs(in_memory);
    NameTable materials{"material", 0};
    for (int i = 0; i < 10; ++i) EXPECT_TRUE(materials.add(absl::StrCat("m", i), i).ok());
    MaterialTable material_table;
    material_table.materials.resize(10);
    MediumNames media;
    NamedTextures textures;
    const std::map<std::string, int> attribute_names;
    TextureTable texture_table;
    MeshAttributes attributes{attribute_names, blobs.source, texture_table};
    std::vector<std::string> warnings;
    ShapeBuilder builder{
        {blobs.source, materials, material_table, media, textures, attributes}, table_, warnings};
    const absl::Status added = builder.add(shape, placed, false, "here");
    EXPECT_TRUE(added.ok()) << added;
    EXPECT_TRUE(builder.add_solids_of_combinations().ok());
  }

  ShapeTable table_;
};

}  // namespace tessera::render::TESSERA_ISA::csg_test
