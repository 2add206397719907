// Files that are read by Assimp, by way of glTF.
#include "unit/import/import_fixture.h"

namespace tessera::client {
namespace {

using testing::HasSubstr;

class AssimpFiles : public ImportTest {
 protected:
  /// Triangles of all shapes.
  static std::size_t triangles_of(const ImportedScene& scene) {
    std::size_t count = 0;
    for (const v1::Shape& shape : scene.scene.shapes()) {
      for (const SceneBlob& blob : scene.blobs) {
        if (blob.ref.digest() == shape.mesh().blob().digest())
          count += wire::decode_mesh(blob.bytes)->triangle_count();
      }
    }
    return count;
  }
};

TEST_F(AssimpFiles, ObjHasTheColoursOfItsMtl) {
  write("paint.mtl", "newmtl red\nKd 0.5 0.25 0.125\n");
  const auto scene = import_scene(
      write("square.obj", "mtllib paint.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red\nf 1 2 3 4\n"),
      {});
  ASSERT_TRUE(scene.ok()) << scene.status().ToString();
  EXPECT_EQ(triangles_of(*scene), 2);
  ASSERT_EQ(scene->scene.materials_size(), 1);
  const v1::GltfMaterial& material = scene->scene.materials(0).gltf();
  EXPECT_EQ(material.base_color().constant().rgb().r(), 0.5f);
  EXPECT_EQ(material.base_color().constant().rgb().b(), 0.125f);
  EXPECT_EQ(material.metallic().constant(), 0);
  EXPECT_EQ(scene->scene.name(), "square");
}

TEST_F(AssimpFiles, StlHasItsTriangles) {
  const auto scene = import_scene(write("one.stl",
                                        "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"
                                        "vertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid one\n"),
                                  {});
  ASSERT_TRUE(scene.ok()) << scene.status().ToString();
  EXPECT_EQ(triangles_of(*scene), 1);
}

TEST_F(AssimpFiles, ColladaIsUprightAndInMetres) {
  const auto scene = import_scene(write("one.dae", R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="9">0 0 0 1 0 0 0 0 2</float_array>
<technique_common><accessor source="#a" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)"),
                                  {});
  ASSERT_TRUE(scene.ok()) << scene.status().ToString();
  ASSERT_EQ(scene->scene.shapes_size(), 1);
  // z of the file is y here.
  const auto& m = scene->scene.shapes(0).world_from_object().elements();
  ASSERT_EQ(m.size(), 16);
  EXPECT_NEAR(m[6], 1, 1e-6);
  EXPECT_NEAR(m[9], -1, 1e-6);
}

TEST_F(AssimpFiles, OfWhichNothingIsSoundAreRefused) {
  for (const char* name : {"a.obj", "a.stl", "a.fbx", "a.dae"}) {
    SCOPED_TRACE(name);
    EXPECT_THAT(error_of(import_scene(write(name, "\x01\x02 nonsense"), {})), HasSubstr(name));
  }
  EXPECT_THAT(error_of(import_scene(folder_ / "absent.fbx", {})), HasSubstr("absent.fbx"));
}

TEST_F(AssimpFiles, OpenUsdIsRefusedByName) {
  EXPECT_THAT(error_of(import_scene(write("a.usdz", ""), {})), HasSubstr("OpenUSD"));
}

}  // namespace
}  // namespace tessera::client
