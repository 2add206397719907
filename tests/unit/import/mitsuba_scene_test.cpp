// Shapes, lights, media, sensors and integrators of Mitsuba scenes.
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "unit/import/mitsuba_fixture.h"
#include "wire/limits.h"
#include "wire/volume_blob.h"

namespace tessera::client {
namespace {

using testing::ElementsAre;
using testing::FloatEq;
using testing::HasSubstr;
using testing::Not;

using MitsubaScene = MitsubaTest;

template <typename T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

constexpr char kObj[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nf 1/1 2/1 3/1\n";
constexpr char kMirror[] = "<transform name='to_world'><scale x='-1'/></transform>";

TEST_F(MitsubaScene, ObjFilesHaveTheirVTurnedOverAndGetSmoothNormals) {
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

TEST_F(MitsubaScene, MeshesThatAppearTwiceAreOneBlob) {
  write("a.obj", kObj);
  const std::string one =
      "<shape type='obj'><string name='filename' value='a.obj'/><transform name='to_world'>";
  const ImportedScene result = scene(one + "<rotate y='1' angle='30'/></transform></shape>" + one +
                                     "<scale value='2'/></transform></shape>");
  EXPECT_EQ(result.blobs.size(), 1u);
}

TEST_F(MitsubaScene, NormalsOfStretchedMeshesAreThoseOfTheWorld) {
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

TEST_F(MitsubaScene, MirroredMeshesKeepTheSideThatTheirVerticesGiveInTheWorld) {
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

TEST_F(MitsubaScene, PlyFilesBringTheirAttributes) {
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

TEST_F(MitsubaScene, SerializedFilesHoldSeveralMeshes) {
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
  EXPECT_EQ(full.uvs[5], 0.25f);  // as it stands
  EXPECT_THAT(error_of(import_xml(with_sensor(shape + "<integer name='shape_index' value='2'/></shape>"))),
              HasSubstr("there is no mesh 2: the file holds 2"));
  write("a.serialized", first.substr(0, first.size() - 9));
  EXPECT_THAT(error_of(import_xml(with_sensor(shape + "</shape>"))),
              HasSubstr("the mesh is damaged or cut off"));
  write("a.serialized", "nonsense");
  EXPECT_THAT(error_of(import_xml(with_sensor(shape + "</shape>"))),
              HasSubstr("scene.xml:3:26: "));  // at the property that names the file
}

TEST_F(MitsubaScene, AnalyticShapesHaveMitsubasParameters) {
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

TEST_F(MitsubaScene, ACubeLooksOutwards) {
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

TEST_F(MitsubaScene, ShapeGroupsBecomeObjects) {
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

TEST_F(MitsubaScene, ShapesWithoutABsdfAreDiffuseOrBlack) {
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

/// A grid of two samples along x, in a box from (0, 0, 0) to (2, 4, 8).
std::string volume_bytes(std::uint32_t channels) {
  std::string bytes = "VOL\x03";
  for (const std::uint32_t n : {1u, 2u, 1u, 1u, channels}) append<std::uint32_t>(bytes, n);
  for (const float x : {0.f, 0.f, 0.f, 2.f, 4.f, 8.f}) append<float>(bytes, x);
  for (std::uint32_t i = 0; i < 2 * channels; ++i) append<float>(bytes, 0.5f * static_cast<float>(i));
  return bytes;
}

TEST_F(MitsubaScene, MediaHaveGridsAndColours) {
  write("a.vol", volume_bytes(1));
  const ImportedScene result = scene(
      "<shape type='sphere'><medium name='interior' type='heterogeneous'><float name='scale' value='5'/>"
      "<volume name='sigma_t' type='gridvolume'><string name='filename' value='a.vol'/>"
      "<boolean name='use_grid_bbox' value='true'/><transform name='to_world'><translate "
      "x='1'/></transform></volume>"
      "<rgb name='albedo' value='.9 .5 .1'/><phase type='hg'><float name='g' "
      "value='-.25'/></phase></medium></shape>");
  ASSERT_EQ(result.scene.media_size(), 1);
  const v1::Medium& medium = result.scene.media(0);
  EXPECT_EQ(result.scene.shapes(0).interior_medium(), medium.name());
  EXPECT_EQ(medium.scale(), 5);
  EXPECT_EQ(medium.g(), -0.25f);
  EXPECT_EQ(medium.albedo().constant().rgb().b(), 0.1f);
  EXPECT_THAT(elements_of(medium.extinction().grid().world_from_grid()),
              ElementsAre(2, 0, 0, 1, 0, 4, 0, 0, 0, 0, 8, 0, 0, 0, 0, 1));
  const auto volume =
      wire::decode_volume(find_blob(result, medium.extinction().grid().blob().digest()).bytes);
  ASSERT_TRUE(volume.ok()) << volume.status();
  EXPECT_EQ(volume->nx, 2u);
  EXPECT_THAT(volume->samples, ElementsAre(0, 0.5f));
}

TEST_F(MitsubaScene, DamagedVolumesAreErrors) {
  const auto error = [&](const std::string& bytes) {
    write("a.vol", bytes);
    return error_of(
        import_xml(with_sensor("<shape type='sdfgrid'>\n<string name='filename' value='a.vol'/></shape>")));
  };
  EXPECT_THAT(error("VOL\x04" + std::string(60, 'x')), HasSubstr("scene.xml:4:1: "));
  EXPECT_THAT(error("VOL\x04" + std::string(60, 'x')), HasSubstr("version 4: expected 3"));
  EXPECT_THAT(error("VOL"), HasSubstr("cut off in its header"));
  std::string cut = volume_bytes(1);
  cut.pop_back();
  EXPECT_THAT(error(cut), HasSubstr("2 samples do not fit"));
  EXPECT_THAT(error(volume_bytes(3)), HasSubstr("a signed distance needs one channel"));
}

TEST_F(MitsubaScene, LightsStandWhereTheyShould) {
  const ImportedScene result = scene(
      "<emitter type='point'><point name='position' x='1' y='2' z='3'/><rgb name='intensity' "
      "value='4'/></emitter>"
      "<emitter type='point'><transform name='to_world'><translate y='7'/></transform></emitter>"
      "<emitter type='directional'><transform name='to_world'><rotate y='1' "
      "angle='90'/></transform></emitter>"
      "<emitter type='directional'><vector name='direction' value='0 -1 0'/></emitter>");
  EXPECT_EQ(result.scene.lights(0).point().position().z(), 3);
  EXPECT_EQ(result.scene.lights(0).point().intensity().rgb().r(), 4);
  EXPECT_EQ(result.scene.lights(1).point().position().y(), 7);
  EXPECT_NEAR(result.scene.lights(2).distant().direction().x(), 1, 1e-15);  // +z turned to +x
  EXPECT_EQ(result.scene.lights(3).distant().direction().y(), -1);
}

TEST_F(MitsubaScene, SpotsFallOffLinearly) {
  const v1::SpotLight spot =
      scene(
          "<emitter type='spot'><transform name='to_world'><lookat origin='0 5 0' target='0 0 "
          "0' up='1 0 0'/></transform>"
          "<float name='cutoff_angle' value='40'/></emitter>")
          .scene.lights(0)
          .spot();
  EXPECT_EQ(spot.falloff(), v1::SpotLight::LINEAR);
  EXPECT_EQ(spot.cone_angle_degrees(), 40);
  EXPECT_EQ(spot.cone_delta_degrees(), 10);  // the beam is three quarters wide
  EXPECT_NEAR(spot.target().y(), 4, 1e-15);
}

TEST_F(MitsubaScene, ProjectorsShineEvenly) {
  const v1::ProjectionLight projector =
      scene(
          "<emitter type='projector'><float name='fov' value='60'/><float name='scale' value='2'/>"
          "<rgb name='irradiance' value='1 2 3'/></emitter>")
          .scene.lights(0)
          .projection();
  EXPECT_TRUE(projector.even_screen());
  EXPECT_THAT(projector.fov_degrees(), FloatEq(60));
  EXPECT_THAT(projector.intensity().rgb().b(), FloatEq(static_cast<float>(6 * std::numbers::pi)));
}

TEST_F(MitsubaScene, EnvironmentsAreLatitudeAndLongitude) {
  write("sky.exr", "x");
  const v1::Light light = scene(
                              "<emitter type='envmap'><string name='filename' value='sky.exr'/>"
                              "<float name='scale' value='3'/></emitter>")
                              .scene.lights(0);
  EXPECT_EQ(light.infinite().mapping(), v1::InfiniteLight::LATITUDE_LONGITUDE);
  EXPECT_EQ(light.infinite().scale(), 3);
  EXPECT_FALSE(light.infinite().image().digest().empty());
}

TEST_F(MitsubaScene, ThingsThatAreNotSupportedAreNamed) {
  const auto error = [&](const std::string& body) { return error_of(import_xml(with_sensor(body))); };
  EXPECT_THAT(
      error("<shape type='rectangle'>\n<emitter type='directionalarea'/></shape>"),
      HasSubstr("scene.xml:4:1: emitter \"directionalarea\" is not supported on a shape: expected area"));
  EXPECT_THAT(error("<emitter type='area'/>"), HasSubstr("must stand inside a shape"));
  EXPECT_THAT(error("<shape type='hair'/>"), HasSubstr("shape \"hair\" is not supported: expected obj, ply"));
  EXPECT_THAT(error("<integrator type='bdpt'/>"), HasSubstr("integrator \"bdpt\" is not supported"));
  EXPECT_THAT(
      error(
          "<shape type='sphere'><medium name='interior' type='homogeneous'><phase type='rayleigh'/></medium>"
          "</shape>"),
      HasSubstr("phase \"rayleigh\" is not supported"));
}

class MitsubaSensor : public MitsubaTest {
 protected:
  v1::Scene sensor(const std::string& type, const std::string& inside) const {
    return succeed(import_xml("<scene version='3.0.0'><sensor type='" + type + "'>" + inside +
                              "</sensor></scene>"))
        .scene;
  }
  static std::string film(const std::string& inside) { return "<film type='hdrfilm'>" + inside + "</film>"; }
};

constexpr char kWide[] = "<integer name='width' value='400'/><integer name='height' value='200'/>";

TEST_F(MitsubaSensor, FieldOfViewIsThatOfTheAxisAskedFor) {
  // tan(fov_y / 2) is half of tan(fov_x / 2) where the film is twice as wide as high.
  const auto fov = [&](const std::string& more) {
    return sensor("perspective", more + film(kWide)).camera().perspective().fov_degrees();
  };
  const auto degrees = [](double tangent) {
    return static_cast<float>(2 * std::atan(tangent) * 180 / std::numbers::pi);
  };
  EXPECT_THAT(fov("<float name='fov' value='90'/>"), FloatEq(degrees(0.5)));
  EXPECT_THAT(fov("<float name='fov' value='90'/><string name='fov_axis' value='y'/>"), FloatEq(90));
  EXPECT_THAT(fov("<float name='fov' value='90'/><string name='fov_axis' value='smaller'/>"), FloatEq(90));
  EXPECT_THAT(fov("<float name='fov' value='90'/><string name='fov_axis' value='diagonal'/>"),
              FloatEq(degrees(1 / std::sqrt(5.0))));
  // 50 mm: half the diagonal of a 36 x 24 frame over the focal length is the tangent of half the diagonal
  // angle.
  EXPECT_THAT(fov(""), FloatEq(degrees(std::hypot(18.0, 12.0) / 50 / std::sqrt(5.0))));
}

TEST_F(MitsubaSensor, XPointsRightHere) {
  const v1::Scene scene = sensor("perspective",
                                 "<transform name='to_world'><lookat origin='1 2 3' target='1 2 4' "
                                 "up='0 1 0'/></transform>");
  EXPECT_THAT(elements_of(scene.camera().world_from_camera()),
              ElementsAre(-1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1));
  EXPECT_FLOAT_EQ(scene.camera().near_clip(), 0.01f);
  EXPECT_FLOAT_EQ(scene.camera().far_clip(), 10000);
}

TEST_F(MitsubaSensor, CropWindowsAndShiftedCentresMoveTheScreen) {
  const v1::Scene scene =
      sensor("perspective", "<float name='principal_point_offset_x' value='0.25'/>" +
                                film(std::string(kWide) +
                                     "<integer name='crop_offset_x' value='100'/><integer name='crop_width' "
                                     "value='200'/><integer name='crop_offset_y' value='150'/>"));
  EXPECT_EQ(scene.film().width(), 200u);
  EXPECT_EQ(scene.film().height(), 50u);
  // The screen is [-2, 2] x [-1, 1]. Columns 100 to 300 are [-1, 1], moved by a quarter of the width; rows
  // 150 to 200 are the lowest quarter.
  EXPECT_THAT(scene.camera().screen_window(), ElementsAre(0, 2, -1, -0.5f));
}

TEST_F(MitsubaSensor, ThinLensesFocus) {
  const v1::Camera camera = sensor("thinlens",
                                   "<float name='aperture_radius' value='.5'/>"
                                   "<float name='focus_distance' value='7'/>")
                                .camera();
  EXPECT_EQ(camera.perspective().lens_radius(), 0.5f);
  EXPECT_EQ(camera.perspective().focal_distance(), 7);
}

TEST_F(MitsubaSensor, OrthographicFilmsAreTwoUnitsWide) {
  const v1::Camera camera =
      sensor("orthographic", "<transform name='to_world'><scale x='10' y='10'/></transform>" + film(kWide))
          .camera();
  ASSERT_TRUE(camera.has_orthographic());
  EXPECT_THAT(camera.screen_window(), ElementsAre(-10, 10, -5, 5));
  EXPECT_THAT(elements_of(camera.world_from_camera()),
              ElementsAre(-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1));
}

TEST_F(MitsubaSensor, FiltersHaveMitsubasWidths) {
  const auto filter = [&](const std::string& rfilter) {
    return sensor("perspective", film(rfilter)).film().filter();
  };
  EXPECT_EQ(filter("").kind(), v1::PixelFilter::GAUSSIAN);
  EXPECT_EQ(filter("").radius_x(), 2);
  EXPECT_EQ(filter("<rfilter type='gaussian'><float name='stddev' value='.25'/></rfilter>").radius_y(), 1);
  EXPECT_EQ(filter("<rfilter type='box'/>").radius_x(), 0.5f);
  EXPECT_EQ(filter("<rfilter type='tent'/>").radius_x(), 1);
  EXPECT_EQ(filter("<rfilter type='catmullrom'/>").c(), 0.5f);
  EXPECT_EQ(filter("<rfilter type='lanczos'/>").tau(), 3);
}

TEST_F(MitsubaSensor, IntegratorsCountSegments) {
  const auto settings = [&](const std::string& integrator) { return scene(integrator).scene.settings(); };
  const std::string two = "<integer name='max_depth' value='2'/>";
  EXPECT_EQ(settings("").integrator(), "path");
  EXPECT_EQ(settings("").max_depth(), wire::kMaxDepth);
  EXPECT_EQ(
      settings("<integrator type='moment'><integrator type='path'>" + two + "</integrator></integrator>")
          .max_depth(),
      1u);
  EXPECT_EQ(settings("<integrator type='direct'/>").max_depth(), 1u);
  EXPECT_EQ(settings("<integrator type='volpathmis'>" + two + "</integrator>").integrator(), "volpath");
  EXPECT_EQ(settings("<integrator type='ptracer'/>").integrator(), "light");
  EXPECT_THAT(
      warnings_of(scene("<integrator type='path'><boolean name='hide_emitters' value='true'/></integrator>")),
      HasSubstr("hide_emitters is not supported"));
}

TEST_F(MitsubaSensor, SamplersSayHowManySamplesOnly) {
  const auto settings = [&](const std::string& type) {
    return sensor("perspective",
                  "<sampler type='" + type + "'><integer name='sample_count' value='9'/></sampler>")
        .settings();
  };
  for (const char* type : {"independent", "multijitter"}) {
    EXPECT_EQ(settings(type).sampler(), "") << type;
    EXPECT_EQ(settings(type).spp(), 9u) << type;
  }
}

TEST_F(MitsubaScene, HeterogeneousMediaEndAtTheBoxOfTheirExtinction) {
  const auto medium = [&](const std::string& type, const std::string& body) {
    const ImportedScene result = scene("<shape type='sphere'><medium name='interior' type='" + type + "'>" +
                                       body + "</medium></shape>");
    EXPECT_EQ(warnings_of(result), "");
    return result.scene.media_size() == 1 ? result.scene.media(0) : v1::Medium();
  };
  const std::string moved =
      "<volume name='sigma_t' type='constvolume'><float name='value' value='2'/><transform name='to_world'>"
      "<scale x='2' y='3' z='4'/><translate x='1' y='0' z='-1'/></transform></volume>";
  const v1::Medium box = medium("heterogeneous", moved);
  EXPECT_EQ(box.extinction().constant().rgb().g(), 2);
  EXPECT_THAT(elements_of(box.world_from_bounds()),
              ElementsAre(2, 0, 0, 1, 0, 3, 0, 0, 0, 0, 4, -1, 0, 0, 0, 1));
  // Turned by 45 degrees about z: the box along the axes around it, from -sqrt(1/2) to sqrt(1/2) and from 0
  // to sqrt(2).
  const v1::Medium turned = medium("heterogeneous",
                                   "<volume name='sigma_t' type='constvolume'><transform "
                                   "name='to_world'><rotate z='1' angle='45'/></transform></volume>");
  ASSERT_EQ(turned.world_from_bounds().elements_size(), 16);
  EXPECT_NEAR(turned.world_from_bounds().elements(0), std::sqrt(2), 1e-6);
  EXPECT_NEAR(turned.world_from_bounds().elements(3), -std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(turned.world_from_bounds().elements(5), std::sqrt(2), 1e-6);
  EXPECT_NEAR(turned.world_from_bounds().elements(7), 0, 1e-6);
  // A colour is a volume too: the unit cube's.
  EXPECT_THAT(elements_of(medium("heterogeneous", "<rgb name='sigma_t' value='1 2 3'/>").world_from_bounds()),
              ElementsAre(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1));
  EXPECT_TRUE(medium("heterogeneous", "").has_world_from_bounds());
  // A homogeneous one is wherever its shape says, and the box of an albedo bounds nothing.
  EXPECT_FALSE(medium("homogeneous", moved).has_world_from_bounds());
}

TEST_F(MitsubaScene, TurnedGridsReachAsFarAsTheBoxAroundThem) {
  const auto medium = [&](const std::string& transform) {
    write("v.vol", volume_bytes(1));
    return scene(
               "<shape type='sphere'><medium name='interior' type='heterogeneous'><volume name='sigma_t' "
               "type='gridvolume'><string name='filename' value='v.vol'/><transform name='to_world'>" +
               transform + "</transform></volume></medium></shape>")
        .scene.media(0);
  };
  EXPECT_FALSE(medium("<scale value='3'/><translate x='5'/>").has_world_from_bounds());
  EXPECT_FALSE(medium("<rotate z='1' angle='90'/>").has_world_from_bounds());
  EXPECT_TRUE(medium("<rotate z='1' angle='30'/>").has_world_from_bounds());
}

TEST_F(MitsubaScene, WhatNobodyAsksForIsSaidOfEveryObject) {
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

TEST_F(MitsubaScene, MeshesThatEmitSayHowOftenMitsubaPicksThem) {
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
