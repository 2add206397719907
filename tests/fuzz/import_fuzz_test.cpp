// Deterministic mutations of sound files: whatever comes out, the importers return, with a scene or with errors.
#include <zlib.h>

#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "fuzz/import_targets.h"
#include "gtest/gtest.h"

namespace tessera::fuzz {
namespace {

constexpr char kPly[] =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float u\n"
    "property float v\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 .5 0 1\n3 0 1 2\n4 0 1 2 3\n";

constexpr char kPbrt[] =
    "Integrator \"path\" \"integer maxdepth\" [ 5 ]\nLookAt 0 1 5  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" "
    "40\n"
    "Film \"rgb\" \"integer xresolution\" [ 64 ] \"integer yresolution\" 32\nSampler \"sobol\" \"integer "
    "pixelsamples\" 4\n"
    "PixelFilter \"gaussian\"\nWorldBegin\nAttribute \"shape\" \"float radius\" 2\n"
    "Texture \"c\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [ .1 .2 .3 ] \"float uscale\" 4\n"
    "MakeNamedMaterial \"m\" \"string type\" [ \"coateddiffuse\" ] \"texture reflectance\" \"c\" \"float roughness\" "
    ".1\n"
    "AttributeBegin\nTranslate 0 1 0\nRotate 30 0 1 0\nAreaLightSource \"diffuse\" \"blackbody L\" 5000 \"float "
    "power\" 9\n"
    "Shape \"sphere\" \"float zmax\" 1\nAttributeEnd\nNamedMaterial \"m\"\nObjectBegin \"o\"\n"
    "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ] \"normal N\" [ 0 0 1 0 0 1 0 0 1 ]\n"
    "  \"point2 uv\" [ 0 0 1 0 0 1 ] \"integer indices\" [ 0 1 2 ]\nObjectEnd\nObjectInstance \"o\"\n"
    "Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" [ 400 1 700 3 ]\n"
    "Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0  1 1 1 ]\nShape \"disk\" # a comment\n"
    "LightSource \"distant\" \"point3 from\" [ 1 1 1 ] \"rgb L\" [ 1 1 1 ]\nLightSource \"infinite\" \"float scale\" "
    ".1\n";

constexpr char kMitsuba[] =
    "<scene version='3.0.0'><default name='n' value='2'/><path value='.'/><integrator type='path'><integer "
    "name='max_depth' value='$n'/></integrator>\n<sensor type='perspective'><float name='fov' value='40'/><transform "
    "name='to_world'><lookat origin='0 1 5' target='0 0 0' up='0 1 0'/></transform><film type='hdrfilm'><rfilter "
    "type='box'/><integer name='width' value='8'/></film><sampler type='independent'/></sensor>\n<bsdf type='twosided' "
    "id='b'><bsdf type='roughplastic'><texture name='diffuse_reflectance' type='checkerboard'><transform "
    "name='to_uv'><scale value='3'/></transform></texture></bsdf></bsdf>\n<bsdf type='mask' id='m'><float name='opacity' "
    "value='.5'/><ref id='b'/></bsdf><alias id='m' as='a'/>\n<shape type='sphere'><point name='center' x='1' y='2' "
    "z='3'/><ref id='a'/><medium name='interior' type='homogeneous'><rgb name='sigma_t' value='1 2 3'/><phase "
    "type='hg'/></medium></shape>\n<shape type='shapegroup' id='g'><shape type='cube'><ref id='b'/></shape></shape><shape "
    "type='instance'><ref id='g'/><transform name='to_world'><rotate x='1' angle='30'/><matrix value='1 0 0 0 1 0 0 0 "
    "1'/></transform></shape>\n<shape type='rectangle'><emitter type='area'><spectrum name='radiance' value='400:1 "
    "700:2'/></emitter></shape><emitter type='spot'/><emitter type='projector'><string name='focal_length' "
    "value='35mm'/></emitter></scene>\n";

constexpr char kObj[] =
    "o a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 1\nvn 0 0 1\nf 1/1/1 2/2/1 3//1\nf -4 -3 -2 -1\n";

constexpr char kText[] =
    "name: \"s\"\nmaterials { name: \"m\" diffuse { reflectance { constant { constant: 0.5 } } } }\n"
    "shapes { sphere { radius: 1 } material: \"m\" world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] "
    "} }\n"
    "lights { point { position { x: 1 } intensity { rgb { r: 1 g: 1 b: 1 } } } }\ncamera { perspective { fov_degrees: "
    "40 } }\n";

/// Binary version of kPly, so that mutations meet counts and indices as bytes.
std::string binary_ply() {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
  const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  bytes.append(reinterpret_cast<const char*>(positions), sizeof(positions));
  const int indices[] = {0, 1, 2};
  for (int face = 0; face < 2; ++face) {
    bytes.push_back(3);
    bytes.append(reinterpret_cast<const char*>(indices), sizeof(indices));
  }
  return bytes;
}

/// One to four edits: bytes changed, pieces removed, doubled, moved, or replaced by something nasty.
std::string mutate(std::string bytes, std::mt19937& random) {
  static const std::vector<std::string> kNasty = {"nan",
                                                  "-1",
                                                  "4294967296",
                                                  "1e308",
                                                  "99999999999999999999",
                                                  "\"",
                                                  "[",
                                                  "]",
                                                  "#",
                                                  "\\",
                                                  "\n",
                                                  std::string(1, '\0'),
                                                  "\xff\xff\xff\xff",
                                                  "AttributeEnd",
                                                  "WorldBegin",
                                                  "ObjectEnd",
                                                  "Include \"fuzz.pbrt\"",
                                                  "\"integer indices\"",
                                                  "0",
                                                  "{",
                                                  "}"};
  const auto pick = [&](std::size_t below) { return below == 0 ? 0 : random() % below; };
  for (std::size_t edits = 1 + pick(4); edits > 0; --edits) {
    const std::size_t at = pick(bytes.size() + 1);
    const std::size_t length = pick(std::min<std::size_t>(16, bytes.size() - at) + 1);
    switch (pick(6)) {
      case 0:
        if (at < bytes.size()) bytes[at] = static_cast<char>(random());
        break;
      case 1:
        bytes.erase(at, length);
        break;
      case 2:
        bytes.insert(pick(bytes.size() + 1), bytes.substr(at, length));
        break;
      case 3:
        bytes.replace(at, length, kNasty[pick(kNasty.size())]);
        break;
      case 4:
        bytes.insert(at, kNasty[pick(kNasty.size())]);
        break;
      case 5:
        if (pick(8) == 0) bytes.resize(at);
        break;
    }
  }
  return bytes;
}

class ImportFuzz : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = (std::filesystem::temp_directory_path() / "tessera-fuzz-XXXXXX").string();
    ASSERT_NE(mkdtemp(folder_.data()), nullptr);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string folder_;
};

TEST_F(ImportFuzz, Ply) {
  std::mt19937 random(1);
  for (int i = 0; i < 200'000; ++i) try_ply(mutate(i % 2 == 0 ? std::string(kPly) : binary_ply(), random));
}

TEST_F(ImportFuzz, Obj) {
  std::mt19937 random(4);
  for (int i = 0; i < 100'000; ++i) try_obj(mutate(kObj, random));
}

TEST_F(ImportFuzz, Volume) {
  std::mt19937 random(5);
  std::string bytes = "VOL\x03";
  for (const std::uint32_t number : {1, 2, 2, 2, 1, 0, 0, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8}) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
  }
  for (int i = 0; i < 100'000; ++i) try_volume(mutate(bytes, random));
}

TEST_F(ImportFuzz, Serialized) {
  // One triangle, deflated.
  std::mt19937 random(6);
  std::string raw(4 + 1 + 16 + 36, '\0');
  raw[1] = 0x10;  // single precision
  raw[5] = 3;
  raw[13] = 1;
  for (const std::uint32_t index : {0, 1, 2}) raw.append(reinterpret_cast<const char*>(&index), sizeof(index));
  std::string compressed(compressBound(raw.size()), '\0');
  uLongf size = compressed.size();
  ASSERT_EQ(compress(reinterpret_cast<Bytef*>(compressed.data()), &size, reinterpret_cast<const Bytef*>(raw.data()),
                     raw.size()),
            Z_OK);
  const std::string bytes = std::string("\x1c\x04\x04\x00", 4) + compressed.substr(0, size);
  for (int i = 0; i < 100'000; ++i) try_serialized(mutate(bytes, random));
}

TEST_F(ImportFuzz, Mitsuba) {
  std::mt19937 random(7);
  for (int i = 0; i < 50'000; ++i) try_mitsuba(mutate(kMitsuba, random), folder_.c_str());
}

TEST_F(ImportFuzz, Pbrt) {
  std::mt19937 random(2);
  for (int i = 0; i < 10'000; ++i) try_pbrt(mutate(kPbrt, random), folder_.c_str());
}

TEST_F(ImportFuzz, TextScene) {
  std::mt19937 random(3);
  for (int i = 0; i < 4'000; ++i) try_text_scene(mutate(kText, random), folder_.c_str());
}

TEST_F(ImportFuzz, TheUnchangedFilesAreSound) {
  // Else the mutations would only ever meet the first error.
  for (const auto& [name, text] : {std::pair{"a.pbrt", kPbrt}, {"a.xml", kMitsuba}, {"a.textproto", kText}}) {
    EXPECT_TRUE(is_accepted(text, (std::filesystem::path(folder_) / name).c_str())) << name;
  }
}

}  // namespace
}  // namespace tessera::fuzz
