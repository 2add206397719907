// How many files a new kind of something touches: for one kind of each family, the files that name it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Kind {
  const char* family;
  std::vector<std::string> identifiers;  // all that the kind is called in the sources
  std::vector<std::string> files;        // all that name it; those of a folder of its own are one: "folder/"
};

/// Messages, lists, models, and readers of messages. Importers and the add-on for Blender translate other
/// formats, and are not counted.
const Kind kKinds[] = {
    {"BSDF",
     {"kPhong", "PhongMaterial", "PhongBsdf", "PhongVariants", "kBlinn", "kMirrorLobe", "phong"},
     {"proto/tessera/v1/material.proto", "worker/render/bsdf/kinds.h", "worker/render/bsdf/model/phong.cpp",
      "worker/render/scene/material/material_kinds.cpp"}},
    // With a photometric file, an amount in units of light, keys of motion, and a method in Python, which
    // plain kinds need not have.
    {"light",
     {"kGoniometric", "GoniometricLight", "goniometric"},
     {"proto/tessera/v1/light.proto", "worker/render/light/light_table.h",
      "worker/render/light/model/goniometric.cpp", "worker/render/scene/light/light_builder.cpp",
      "worker/render/scene/light/light_builder.h", "worker/render/scene/light/light_amount.cpp",
      "worker/render/scene/light/amounts_of_lights.cpp", "proto/wire/algorithm_fit.cpp",
      "python/tessera/_lights.py"}},
    // With rays of the client's own, by which it looks new views of light fields up.
    {"sensor",
     {"SphericalCamera", "kOctahedral", "OctahedralSensor"},
     {"client/capture/camera_rays.cpp", "proto/tessera/v1/camera.proto", "python/tessera/_cameras.py",
      "worker/render/scene/view/all_around.cpp", "worker/render/sensor/model/spherical.cpp",
      "worker/render/sensor/sensor_record.h"}},
    {"structure that rays search",
     {"ACCELERATOR_OCTREE", "kOctree", "Octree", "build_octree"},
     {"proto/tessera/v1/settings.proto", "worker/render/accel/octree/",
      "worker/render/accel/structure/structure_list.h"}},
    {"AOV",
     {"AOV_MATERIAL_ID", "kMaterialId", "material_id"},
     {"proto/tessera/v1/job.proto", "proto/wire/aov_list.h",
      "worker/render/transport/vertex/first_hits.cpp"}},
    {"algorithm with a setting",
     {"AmbientOcclusion", "ao"},
     {"proto/tessera/v1/settings.proto", "proto/wire/algorithm.cpp",
      "worker/render/textbook/ambient_occlusion/"}},
    {"shape",
     {"kTorus", "TorusShape", "Torus", "torus"},
     {"proto/tessera/v1/shape.proto", "worker/render/scene/shape/round_solids.cpp",
      "worker/render/shape/shape_table.h", "worker/render/shape/torus.cpp"}},
    {"option of the structures that rays search",
     {"grid_density", "kGridDensity"},
     {"proto/tessera/v1/settings.proto", "worker/render/accel/grid/",
      "worker/render/accel/structure/structure_options.h", "worker/render/scene/scene_content.cpp"}},
    {"option of lights",
     {"light_selection", "LightSelection", "LIGHT_SELECTION_TREE"},
     {"proto/tessera/v1/settings.proto", "worker/render/light/light_build.cpp",
      "worker/render/light/light_build.h", "worker/render/scene/light/light_builder.cpp"}},
    {"option of a view",
     {"texture_footprint"},
     {"proto/tessera/v1/settings.proto", "proto/tessera/v1/job.proto", "worker/render/scene/view/view.cpp"}},
};

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Comments of C++ and of messages may name what they like.
std::string without_comments(const std::string& text) {
  std::istringstream in(text);
  std::string result;
  for (std::string line; std::getline(in, line);) result += line.substr(0, line.find("//")) + '\n';
  return result;
}

bool names(const std::string& text, const std::string& identifier) {
  const auto is_part = [&](std::size_t i) {
    return i < text.size() && (std::isalnum(static_cast<unsigned char>(text[i])) || text[i] == '_');
  };
  for (std::size_t at = text.find(identifier); at != std::string::npos; at = text.find(identifier, at + 1)) {
    if (!is_part(at - 1) && !is_part(at + identifier.size())) return true;
  }
  return false;
}

bool is_source(const fs::path& file) {
  static const std::set<std::string> extensions = {".h",   ".cpp", ".proto", ".py",
                                                   ".txt", ".js",  ".html",  ".cmake"};
  const std::string path = file.string();
  return extensions.contains(file.extension().string()) && !path.starts_with("client/import/") &&
         !path.starts_with("python/blender/") && !path.starts_with("python/tests/");
}

/// The product's files, without their comments.
const std::vector<std::pair<std::string, std::string>>& sources() {
  static const auto all = [] {
    std::vector<std::pair<std::string, std::string>> found;
    for (const char* const root : {"proto", "lib", "server", "worker", "client", "python"}) {
      for (const auto& entry : fs::recursive_directory_iterator(root)) {
        if (entry.is_regular_file() && is_source(entry.path()))
          found.emplace_back(entry.path().string(), without_comments(text_of(entry.path())));
      }
    }
    return found;
  }();
  return all;
}

/// The files that name the kind, but for those in its own folder, which is named instead.
std::set<std::string> places_of(const Kind& kind) {
  std::set<std::string> places;
  for (const auto& [path, text] : sources()) {
    if (std::ranges::none_of(kind.identifiers,
                             [&, &own = text](const auto& name) { return names(own, name); }))
      continue;
    std::string place = path;
    for (const std::string& own : kind.files) {
      if (own.ends_with('/') && path.starts_with(own)) place = own;
    }
    places.insert(place);
  }
  return places;
}

TEST(PlacesOfKinds, AreThoseThatTheirFamiliesHave) {
  EXPECT_GT(sources().size(), 800u);  // the test reads what it believes it reads
  for (const Kind& kind : kKinds)
    EXPECT_THAT(places_of(kind), testing::UnorderedElementsAreArray(kind.files))
        << kind.family << ": a kind is named in another set of files than it was";
}

/// A kind with a folder or a file for itself is taken from there: no build file lists it.
TEST(PlacesOfKinds, ModelsAreInNoListOfFiles) {
  for (const char* const folder : {"bsdf", "light", "sensor", "shape", "textbook", "transport"}) {
    const std::string text = text_of(fs::path("worker/render") / folder / "CMakeLists.txt");
    EXPECT_NE(text.find("file(GLOB"), std::string::npos) << folder;
  }
}

}  // namespace
