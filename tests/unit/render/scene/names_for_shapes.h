// A builder of shapes with inputs that are only names, for fixtures.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "render/scene/shape/shape_builder.h"
#include "unit/render/scene/builder_inputs.h"

namespace tessera::render {

class NamesForShapes : public testing::Test {
 protected:
  /// Names for shapes; material number `usual_material` is that of shapes which name none.
  explicit NamesForShapes(int usual_material = 0, std::map<std::string, int> attribute_names = {})
      : materials_{"material", usual_material}, attribute_names_(std::move(attribute_names)) {}

  NameTable materials_;
  MaterialTable material_table_;
  MediumNames media_;
  NamedTextures textures_;
  BlobsInMemory blobs_;
  const std::map<std::string, int> attribute_names_;
  TextureTable texture_table_;
  MeshAttributes attributes_{attribute_names_, blobs_.source, texture_table_};
  std::vector<std::string> warnings_;
  ShapeTable table_;
  ShapeBuilder shapes_{
      {blobs_.source, materials_, material_table_, media_, textures_, attributes_}, table_, warnings_};
};

}  // namespace tessera::render
