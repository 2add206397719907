// Deterministic mutations of sound files: whatever comes out, the importers return, with a scene or with errors.
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
  for (const auto& [name, text] : {std::pair{"a.pbrt", kPbrt}, {"a.textproto", kText}}) {
    EXPECT_TRUE(is_accepted(text, (std::filesystem::path(folder_) / name).c_str())) << name;
  }
}

}  // namespace
}  // namespace tessera::fuzz
