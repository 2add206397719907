// Every kind of a family has a model: each puts itself into the table, which no list of files holds together.
#include <gtest/gtest.h>

#include <typeinfo>

#include "render/bsdf/bsdf.h"
#include "render/light/light.h"
#include "render/sensor/sensor.h"
#include "render/shape/analytic_shape.h"

namespace tessera::render::TESSERA_ISA {
namespace {

template <class Kind, class F>
void for_each_kind(F&& f) {
  for (int i = 0; i < static_cast<int>(Kind::kCount); ++i) f(static_cast<Kind>(i), i);
}

TEST(Models, EveryKindHasOne) {
  for_each_kind<BsdfKind>([](BsdfKind kind, int i) {
    EXPECT_EQ(bsdf_model(kind) != nullptr, kind != BsdfKind::kMix) << "BSDF " << i;
  });
  // One that is missing cannot be read.
  for_each_kind<LightKind>([](LightKind kind, int i) {
    EXPECT_NE(typeid(light_model(kind)), typeid(LightModel)) << "light " << i;
  });
  for_each_kind<SensorKind>([](SensorKind kind, int i) {
    EXPECT_NE(typeid(sensor_model(kind)), typeid(SensorModel)) << "sensor " << i;
  });
  for_each_kind<ShapeKind>([](ShapeKind kind, int i) {
    const bool is_embrees = kind == ShapeKind::kTriangles || kind == ShapeKind::kCurves;
    EXPECT_EQ(analytic_shape(kind) != nullptr, !is_embrees) << "shape " << i;
  });
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
