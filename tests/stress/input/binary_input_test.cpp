// Bad numbers in binary files: meshes, volumes and images.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "stress/input/input_judge.h"
#include "stress/input/sample_files.h"
#include "support/process/temp_dir.h"

namespace tessera::stress {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kBadFloats[] = {std::numeric_limits<float>::quiet_NaN(),
                                kInfinity,
                                -kInfinity,
                                3e38f,
                                -3e38f,
                                1e20f,
                                1e12f,
                                1e-45f,
                                0,
                                -1};

class BinaryInput : public testing::Test {
 protected:
  std::filesystem::path in_folder(const std::string& name) const { return folder_.path() / name; }

  /// A Mitsuba scene with this in it, over which the sky shines.
  std::filesystem::path mitsuba_scene(const std::string& element) const {
    write_bytes(in_folder("scene.xml"),
                "<scene version='3.0.0'><integrator type='volpath'/><sensor type='perspective'><transform "
                "name='to_world'><lookat "
                "origin='0 3 3' target='0 0 0' up='0 1 0'/></transform></sensor><emitter type='constant'/>" +
                    element + "</scene>");
    return in_folder("scene.xml");
  }

  /// Every number of the file (written to `bad` as `finished` makes it) in every bad way.
  template <typename Finish>
  void walk(const BinaryFile& file, const std::filesystem::path& bad, const std::filesystem::path& scene,
            const Finish& finished) {
    InputJudge judge;
    write_bytes(bad, finished(file.bytes));
    ASSERT_EQ(judge.judge_file(scene, bad), "");
    ASSERT_EQ(judge.tally().rendered, 1u) << "the file as it is must be taken";
    for (std::size_t i = 0; i < file.numbers; ++i) {
      for (const float number : kBadFloats) {
        std::string changed = file.bytes;
        char raw[4];
        std::memcpy(raw, &number, 4);
        if (file.big_endian) std::reverse(raw, raw + 4);
        changed.replace(file.first_number + 4 * i, 4, raw, 4);
        write_bytes(bad, finished(changed));
        EXPECT_EQ(judge.judge_file(scene, bad), "") << "number " << i << " is " << number;
      }
    }
    std::printf("%s: %s\n", bad.filename().c_str(), judge.tally().to_string().c_str());
  }

 private:
  support::TempDir folder_;
};

std::string as_it_is(const std::string& bytes) { return bytes; }

TEST_F(BinaryInput, PlyOfBothEnds) {
  const auto scene = mitsuba_scene("<shape type='ply'><string name='filename' value='mesh.ply'/></shape>");
  for (const bool big_endian : {false, true})
    walk(binary_ply(big_endian), in_folder("mesh.ply"), scene, as_it_is);
}

TEST_F(BinaryInput, Serialized) {
  const auto scene =
      mitsuba_scene("<shape type='serialized'><string name='filename' value='mesh.serialized'/></shape>");
  walk(raw_serialized(), in_folder("mesh.serialized"), scene, compress_serialized);
}

TEST_F(BinaryInput, VolumeAsMedium) {
  const auto scene = mitsuba_scene(
      "<shape type='cube'><bsdf type='null'/><medium type='heterogeneous' name='interior'><volume "
      "type='gridvolume' "
      "name='sigma_t'>"
      "<string name='filename' value='grid.vol'/></volume><float name='albedo' "
      "value='.8'/></medium></shape>");
  walk(volume_file(), in_folder("grid.vol"), scene, as_it_is);
}

TEST_F(BinaryInput, VolumeAsDistance) {
  const auto scene =
      mitsuba_scene("<shape type='sdfgrid'><string name='filename' value='grid.vol'/></shape>");
  BinaryFile file = volume_file();
  const float inside = -3;
  std::memcpy(file.bytes.data() + file.first_number + 4 * 6, &inside, 4);
  walk(file, in_folder("grid.vol"), scene, as_it_is);
}

/// A bad pixel in an image that colours, bends, hides, lights or surrounds things.
TEST_F(BinaryInput, Images) {
  const std::string image =
      "<texture type='bitmap' name='NAME'><string name='filename' value='FILE'/></texture>";
  const std::string rectangle_begin =
      "<shape type='rectangle'><transform name='to_world'><rotate x='1' angle='-90'/></transform>";
  const std::string uses[] = {
      rectangle_begin + "<bsdf type='diffuse'>reflectance</bsdf></shape>",
      rectangle_begin + "<bsdf type='roughconductor'>alpha</bsdf></shape>",
      rectangle_begin + "<bsdf type='principled'>roughness</bsdf></shape>",
      rectangle_begin + "<bsdf type='bumpmap'>arbitrary<bsdf type='diffuse'/></bsdf></shape>",
      rectangle_begin + "<bsdf type='normalmap'>normalmap<bsdf type='diffuse'/></bsdf></shape>",
      rectangle_begin + "<bsdf type='mask'>opacity<bsdf type='diffuse'/></bsdf></shape>",
      rectangle_begin + "<emitter type='area'>radiance</emitter></shape>",
      "<emitter type='envmap'><string name='filename' value='FILE'/></emitter>",
  };
  const auto replace_all = [](std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
      text.replace(at, from.size(), to);
    return text;
  };
  InputJudge judge;
  for (const std::string& use : uses) {
    std::string element = use;
    for (const char* name :
         {"reflectance", "alpha", "roughness", "arbitrary", "normalmap", "opacity", "radiance"}) {
      const std::string here = std::string(">") + name + "<";
      element = replace_all(element, here, ">" + replace_all(image, "NAME", name) + "<");
    }
    for (const char* file : {"image.exr", "half.exr", "image.hdr", "image.pfm", "image.tif", "image.png"}) {
      const auto scene = mitsuba_scene(replace_all(element, "FILE", file));
      for (const float number : kBadFloats) {
        SCOPED_TRACE(testing::Message() << use << " with " << file << " of " << number);
        std::vector<float> rgb(24, 0.5f);
        for (const std::size_t i : {3, 4, 5, 13, 20}) rgb[i] = number;
        write_image(in_folder(file), 4, rgb, std::string(file) == "half.exr");
        EXPECT_EQ(judge.judge_file(scene, in_folder(file)), "");
      }
    }
  }
  EXPECT_GT(judge.tally().rendered, 100u) << "most must get to be rendered for this to be a test";
  std::printf("images: %s\n", judge.tally().to_string().c_str());
}

}  // namespace
}  // namespace tessera::stress
