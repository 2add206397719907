// Shapes of Mitsuba scenes: meshes from files, analytic shapes, groups.
#include <zlib.h>

#include <cmath>
#include <cstring>

#include "unit/import/mitsuba_fixture.h"

namespace tessera::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

using MitsubaShapes = MitsubaTest;

constexpr char kObj[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nf 1/1 2/1 3/1\n";
constexpr char kMirror[] = "<transform name='to_world'><scale x='-1'/></transform>";

TEST_F(MitsubaShapes, ObjFilesHaveTheirVTurnedOverAndGetSmoothNormals) {
  write("a.obj", kObj);
  const ImportedScene result = scene(
      "<shape type='obj'><string name='filename' value='a.obj'/></shape>"
      "<shape type='obj'><string name='filename' value='a.obj'/><boolean name='flip_tex_coords' "
      "value='false'/>"
      "<boolean name='face_normals' value='true'/></shape>");
  const wire::MeshView smooth = mesh_of(result, result.scene.shapes(0)),
                       flat = mesh_of(result, result.scene.shapes(1));
  EXPECT_EQ(smooth.uvs[1], 0.75f);
  EXPECT_THAT(smooth.normals.subspan(0, 3), ElementsAre(0, 0, 1));
  EXPECT_EQ(flat.uvs[1], 0.25f);
  EXPECT_TRUE(flat.normals.empty());
}

TEST_F(MitsubaShapes, MeshesThatAppearTwiceAreOneBlob) {
  write("a.obj", kObj);
  const std::string one =
      "<shape type='obj'><string name='filename' value='a.obj'/><transform name='to_world'>";
  const ImportedScene result = scene(one + "<rotate y='1' angle='30'/></transform></shape>" + one +
                                     "<scale value='2'/></transform></shape>");
  EXPECT_EQ(result.blobs.size(), 1u);
}

TEST_F(MitsubaShapes, NormalsOfStretchedMeshesAreThoseOfTheWorld) {
  // A roof: two faces meet at the edge from 0 to y. Stretched, they meet at other angles.
  write("a.obj", "v 0 0 0\nv 0 1 0\nv 1 0 0\nv -1 0 -1\nf 1 3 2\nf 1 2 4\n");
  const ImportedScene result = scene(
      "<shape type='obj'><string name='filename' value='a.obj'/><transform name='to_world'><scale "
      "z='3'/></transform>"
      "</shape>");
  const wire::MeshView mesh = mesh_of(result, result.scene.shapes(0));
  // In the world the faces' normals are (0, 0, 1) and (-3, 0, 1) / sqrt(10), each with angles of 90 degrees
  // at vertex 0.
  const double x = -3 / std::sqrt(10.0), z = 1 + 1 / std::sqrt(10.0);
  // Object normals transform by the inverse transpose: z is divided by 3 on the way back to the world.
  const double ratio = mesh.normals[0] / (mesh.normals[2] / 3);
  EXPECT_NEAR(ratio, x / z, 1e-6);
}

TEST_F(MitsubaShapes, MirroredMeshesKeepTheSideThatTheirVerticesGiveInTheWorld) {
  write("a.obj", kObj);
  write("n.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n");
  const std::string medium = "<medium type='homogeneous' name='interior' id='m'/>";
  const ImportedScene result =
      scene("<shape type='obj'><string name='filename' value='a.obj'/>" + std::string(kMirror) + medium +
            "</shape><shape type='obj'><string name='filename' value='n.obj'/>" + kMirror +
            "<ref name='interior' id='m'/></shape><shape type='rectangle'>" + kMirror +
            "</shape><shape type='disk'>" + kMirror + "</shape><shape type='sphere'>" + kMirror + "</shape>");
  // A mirrored triangle's own normal would be turned over again here.
  EXPECT_TRUE(result.scene.shapes(0).reverse_orientation());
  EXPECT_EQ(result.scene.shapes(0).interior_medium(), "m");
  // With normals of its own the shading side is theirs, while Mitsuba tells media by the triangle.
  EXPECT_FALSE(result.scene.shapes(1).reverse_orientation());
  EXPECT_EQ(result.scene.shapes(1).exterior_medium(), "m");
  // Mitsuba transforms the normals of rectangles and disks; those of mirrored spheres point inwards.
  EXPECT_FALSE(result.scene.shapes(2).reverse_orientation());
  EXPECT_TRUE(result.scene.shapes(3).reverse_orientation());
  EXPECT_FALSE(result.scene.shapes(4).reverse_orientation());
}

TEST_F(MitsubaShapes, PlyFilesBringTheirAttributes) {
  write(
      "a.ply",
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "property float heat_0\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face 1\nproperty list uchar int vertex_indices\nproperty float tint_r\nproperty float tint_g\n"
      "property float tint_b\nend_header\n"
      "0 0 0 .1 255 0 0\n1 0 0 .2 0 255 0\n1 1 0 .3 0 0 255\n0 1 0 .4 0 0 188\n4 0 1 2 3 .5 .6 .7\n");
  const ImportedScene result = scene("<shape type='ply'><string name='filename' value='a.ply'/></shape>");
  const auto& attributes = result.scene.shapes(0).mesh().attributes();
  ASSERT_EQ(attributes.size(), 3);
  const auto values = [&](int i) {
    const std::string& bytes = find_blob(result, attributes[i].blob().digest()).bytes;
    std::vector<float> floats(bytes.size() / sizeof(float));
    std::memcpy(floats.data(), bytes.data(), bytes.size());
    return floats;
  };
  EXPECT_EQ(attributes[0].name(), "vertex_color");
  EXPECT_EQ(attributes[0].channels(), 3u);
  EXPECT_EQ(values(0)[0], 1);
  EXPECT_NEAR(values(0)[11], 0.5029, 1e-4);  // sRGB 188 of 255 in linear light
  EXPECT_EQ(attributes[1].name(), "vertex_heat");
  EXPECT_THAT(values(1), ElementsAre(0.1f, 0.2f, 0.3f, 0.4f));
  EXPECT_EQ(attributes[2].name(), "face_tint_color");
  EXPECT_TRUE(attributes[2].per_face());
  EXPECT_THAT(values(2), ElementsAre(0.5f, 0.6f, 0.7f, 0.5f, 0.6f, 0.7f));  // the quad is two triangles
}

/// One triangle, as a zlib stream of format version 4.
std::string serialized_stream(std::uint32_t flags, bool doubles) {
  std::string raw;
  append<std::uint32_t>(raw, flags | (doubles ? 0x2000 : 0x1000));
  raw += std::string("mesh") + '\0';
  append<std::uint64_t>(raw, 3);
  append<std::uint64_t>(raw, 1);
  const auto number = [&](double x) {
    doubles ? append<double>(raw, x) : append<float>(raw, static_cast<float>(x));
  };
  for (const double x : {0, 0, 0, 2, 0, 0, 0, 2, 0}) number(x);
  if (flags & 1)
    for (const double x : {0, 0, -1, 0, 0, -1, 0, 0, -1}) number(x);
  if (flags & 2)
    for (const double x : {0.0, 0.0, 1.0, 0.0, 0.0, 0.25}) number(x);
  if (flags & 8)
    for (int i = 0; i < 9; ++i) number(0.5);
  for (const std::uint32_t i : {0, 1, 2}) append<std::uint32_t>(raw, i);
  std::string compressed(compressBound(raw.size()), '\0');
  uLongf size = compressed.size();
  EXPECT_EQ(compress(reinterpret_cast<Bytef*>(compressed.data()), &size,
                     reinterpret_cast<const Bytef*>(raw.data()), raw.size()),
            Z_OK);
  compressed.resize(size);
  std::string bytes;
  append<std::uint16_t>(bytes, 0x041C);
  append<std::uint16_t>(bytes, 4);
  return bytes + compressed;
}

TEST_F(MitsubaShapes, SerializedFilesHoldSeveralMeshes) {
  const std::string first = serialized_stream(0, false), second = serialized_stream(1 | 2 | 8, true);
  std::string bytes = first + second;
  append<std::uint64_t>(bytes, 0);
  append<std::uint64_t>(bytes, first.size());
  append<std::uint32_t>(bytes, 2);
  write("a.serialized", bytes);
  const std::string shape = "<shape type='serialized'><string name='filename' value='a.serialized'/>";
  const ImportedScene result =
      scene(shape + "</shape>" + shape + "<integer name='shape_index' value='1'/></shape>");
  const wire::MeshView plain = mesh_of(result, result.scene.shapes(0)),
                       full = mesh_of(result, result.scene.shapes(1));
  EXPECT_EQ(plain.positions[3], 2);
  EXPECT_THAT(plain.normals.subspan(0, 3), ElementsAre(0, 0, 1));  // computed
  EXPECT_TRUE(plain.uvs.empty());
  EXPECT_THAT(full.normals.subspan(0, 3), ElementsAre(0, 0, -1));
  EXPECT_EQ(full.uvs[5], 0.25f);  // not flipped
  EXPECT_THAT(error_of(import_xml(with_sensor(shape + "<integer name='shape_index' value='2'/></shape>"))),
              HasSubstr("there is no mesh 2: the file holds 2"));
  write("a.serialized", first.substr(0, first.size() - 9));
  EXPECT_THAT(error_of(import_xml(with_sensor(shape + "</shape>"))),
              HasSubstr("the mesh is damaged or cut off"));
  write("a.serialized", "nonsense");
  EXPECT_THAT(error_of(import_xml(with_sensor(shape + "</shape>"))),
              HasSubstr("scene.xml:3:26: "));  // the property that names the file
}

TEST_F(MitsubaShapes, AnalyticShapesHaveMitsubasParameters) {
  const ImportedScene result = scene(
      "<shape type='sphere'><point name='center' x='1' y='2' z='3'/><float name='radius' value='4'/></shape>"
      "<shape type='cylinder'><point name='p0' value='1 0 0'/><point name='p1' value='1 0 5'/>"
      "<float name='radius' value='2'/></shape><shape type='disk'><boolean name='flip_normals' "
      "value='true'/></shape>");
  const v1::Shape &sphere = result.scene.shapes(0), &cylinder = result.scene.shapes(1),
                  &disk = result.scene.shapes(2);
  EXPECT_EQ(sphere.sphere().radius(), 4);
  EXPECT_EQ(elements_of(sphere.world_from_object())[11], 3);
  // pbrt's v is 0 at the lower pole, Mitsuba's at the upper.
  EXPECT_THAT(sphere.uv_transform(), ElementsAre(1, 0, 0, 0, -1, 1));
  EXPECT_EQ(cylinder.cylinder().radius(), 2);
  EXPECT_EQ(cylinder.cylinder().z_max(), 5);
  EXPECT_THAT(elements_of(cylinder.world_from_object()),
              ElementsAre(1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1));
  // pbrt: u = phi / 2 pi, v = 1 - r. Mitsuba: u = r, v = phi / 2 pi.
  EXPECT_THAT(disk.uv_transform(), ElementsAre(0, -1, 1, 1, 0, 0));
  EXPECT_TRUE(disk.reverse_orientation());
}

TEST_F(MitsubaShapes, ACubeLooksOutwards) {
  const ImportedScene result = scene("<shape type='cube'/>");
  const wire::MeshView mesh = mesh_of(result, result.scene.shapes(0));
  ASSERT_EQ(mesh.triangle_count(), 12u);
  for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
    const float* p[3];
    for (int k = 0; k < 3; ++k) p[k] = &mesh.positions[3 * mesh.indices[t + k]];
    const float* n = &mesh.normals[3 * mesh.indices[t]];
    const float u[] = {p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2]};
    const float v[] = {p[2][0] - p[0][0], p[2][1] - p[0][1], p[2][2] - p[0][2]};
    const float cross[] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    // Sides of length 2: twice the area is 4, along the normal, which points away from the centre.
    EXPECT_EQ(cross[0] * n[0] + cross[1] * n[1] + cross[2] * n[2], 4);
    EXPECT_EQ(p[0][0] * n[0] + p[0][1] * n[1] + p[0][2] * n[2], 1);
  }
}

TEST_F(MitsubaShapes, ShapeGroupsBecomeObjects) {
  const ImportedScene result = scene(
      "<shape type='shapegroup' id='g'><shape type='sphere'/><shape type='cube'/></shape>"
      "<shape type='instance'><ref id='g'/></shape><shape type='instance'><ref id='g'/><transform "
      "name='to_world'>"
      "<translate x='2'/></transform></shape>");
  EXPECT_EQ(result.scene.shapes_size(), 0);
  ASSERT_EQ(result.scene.objects_size(), 1);
  EXPECT_EQ(result.scene.objects(0).shapes_size(), 2);
  ASSERT_EQ(result.scene.instances_size(), 2);
  EXPECT_EQ(result.scene.instances(0).object(), "g");
  EXPECT_EQ(elements_of(result.scene.instances(1).world_from_instance())[3], 2);
}

TEST_F(MitsubaShapes, ShapeGroupsMayHoldOthers) {
  const ImportedScene result = scene(
      "<shape type='shapegroup' id='leaf'><shape type='disk'/></shape>"
      "<shape type='shapegroup' id='tree'><shape type='sphere'/><shape type='instance'><ref id='leaf'/>"
      "<transform name='to_world'><translate y='3'/></transform></shape></shape>"
      "<shape type='instance'><ref id='tree'/></shape>");
  ASSERT_EQ(result.scene.objects_size(), 2);
  const v1::Object& tree = result.scene.objects(0);
  EXPECT_EQ(tree.name(), "tree");
  EXPECT_EQ(tree.shapes_size(), 1);
  ASSERT_EQ(tree.instances_size(), 1);
  EXPECT_EQ(tree.instances(0).object(), "leaf");
  EXPECT_EQ(elements_of(tree.instances(0).world_from_instance())[7], 3);
  EXPECT_EQ(result.scene.objects(1).name(), "leaf");
  EXPECT_EQ(result.scene.instances_size(), 1);
}

TEST_F(MitsubaShapes, ShapesWithoutABsdfAreDiffuseOrBlack) {
  const ImportedScene result =
      scene("<shape type='sphere'/><shape type='sphere'><emitter type='area'/></shape>");
  const auto albedo = [&](int i) {
    const v1::Material m = find_material(result, result.scene.shapes(i).material());
    EXPECT_TRUE(m.one_sided());
    return m.diffuse().reflectance().constant().rgb().g();
  };
  EXPECT_EQ(albedo(0), 0.5f);
  EXPECT_EQ(albedo(1), 0);
  EXPECT_EQ(result.scene.shapes(1).area_light().radiance().rgb().r(), 1);
}

TEST_F(MitsubaShapes, WhatNobodyAsksForIsSaidOfEveryObject) {
  // Nested objects too, however deep they stand.
  const ImportedScene result = scene(
      "<shape type='sphere'><medium name='interior' type='heterogeneous'>\n"
      "<volume name='sigma_t' type='constvolume'><float name='volume_size' value='1'/></volume>\n"
      "<phase type='hg'><float name='gee' value='1'/></phase></medium>\n"
      "<bsdf type='diffuse'><texture type='checkerboard' name='reflectance'><float name='kolor' "
      "value='1'/></texture>\n"
      "</bsdf><emitter type='area'><float name='power' value='1'/></emitter></shape>\n"
      "<bsdf type='diffuse' id='unused'><float name='reflectence' value='1'/></bsdf>");
  const std::string warnings = warnings_of(result);
  EXPECT_THAT(warnings, HasSubstr("scene.xml:4:43: parameter \"volume_size\" of volume \"constvolume\""));
  EXPECT_THAT(warnings, HasSubstr("scene.xml:5:18: parameter \"gee\" of phase \"hg\""));
  EXPECT_THAT(warnings, HasSubstr("parameter \"kolor\" of texture \"checkerboard\""));
  EXPECT_THAT(warnings, HasSubstr("parameter \"power\" of emitter \"area\""));
  // Textures that no shape refers to have no effect.
  EXPECT_THAT(warnings, Not(HasSubstr("reflectence")));
}

TEST_F(MitsubaShapes, MeshesThatEmitSayHowOftenMitsubaPicksThem) {
  write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n");
  const std::string emitter =
      "<emitter type='area'><float name='sampling_weight' value='3'/></emitter></shape>";
  const ImportedScene result =
      scene("<emitter type='constant'/><shape type='obj'><string name='filename' value='a.obj'/>" + emitter +
            "<shape type='sphere'>" + emitter);
  EXPECT_FLOAT_EQ(result.scene.shapes(0).area_light().interpolated_normal_pick(), 3.0f / 7);
  EXPECT_FALSE(result.scene.shapes(1).area_light().has_interpolated_normal_pick());
  EXPECT_EQ(warnings_of(result), "");
}

}  // namespace
}  // namespace tessera::client
