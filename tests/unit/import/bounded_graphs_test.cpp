// Elements of scene files that refer to one another: what holds itself is refused by name, and so is what
// would grow with every level of a small file. Unbounded, these would not end.
#include <algorithm>
#include <random>

#include "unit/import/gltf_fixture.h"
#include "unit/import/mitsuba_fixture.h"

namespace tessera::client {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string number(int i) { return std::to_string(i); }

// ---------------------------------------------------------------- glTF

class GltfGraphs : public GltfTest {
 protected:
  using Children = std::vector<std::vector<int>>;

  static Json document_of(const Children& children) {
    Json nodes = Json::array();
    for (const std::vector<int>& list : children)
      nodes.push_back(list.empty() ? Json::object() : Json{{"children", list}});
    return {{"asset", {{"version", "2.0"}}}, {"nodes", nodes}};
  }

  /// Whether every node has one parent at most, and no way leads back to where it began.
  static bool is_forest(const Children& children) {
    std::vector<int> parents(children.size(), -1);
    for (int i = 0; i < static_cast<int>(children.size()); ++i) {
      for (const int child : children[static_cast<std::size_t>(i)]) {
        int& parent = parents[static_cast<std::size_t>(child)];
        if (parent >= 0) return false;
        parent = i;
      }
    }
    for (int start : parents) {
      for (std::size_t steps = 0; start >= 0; start = parents[static_cast<std::size_t>(start)]) {
        if (++steps > children.size()) return false;
      }
    }
    return true;
  }
};

TEST_F(GltfGraphs, NodesWithTwoParentsAndCirclesAreRefusedByName) {
  EXPECT_THAT(error_of(import_scene(write("scene.gltf", R"({"asset":{"version":"2.0"},"nodes":[)"
                                                        R"({"children":[1]},{"children":[2]},)"
                                                        R"({"children":[1]}]})"),
                                    {})),
              AllOf(HasSubstr("/nodes/2/children/0: node 1 has another parent: node 0"),
                    HasSubstr("node 1 is among its own descendants")));
  // Two ways lead from each of forty levels to the next: 2^40 in all.
  Children diamonds(121);
  for (int i = 0; i < 120; i += 3) {
    const auto at = static_cast<std::size_t>(i);
    diamonds[at] = {i + 1, i + 2};
    diamonds[at + 1] = diamonds[at + 2] = {i + 3};
  }
  EXPECT_THAT(error_of(import_gltf(document_of(diamonds))), HasSubstr("node 3 has another parent: node 1"));
}

TEST_F(GltfGraphs, OfRandomNodesThoseAreAcceptedThatAreForests) {
  std::mt19937 random(1);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  int forests = 0, others = 0;
  for (int round = 0; round < 1000; ++round) {
    const int nodes = 1 + below(8), edges = below(nodes + 2);
    Children children(static_cast<std::size_t>(nodes));
    for (int e = 0; e < edges; ++e) {
      std::vector<int>& list = children[static_cast<std::size_t>(below(nodes))];
      // The schema refuses a child that is listed twice.
      if (const int child = below(nodes); std::ranges::find(list, child) == list.end()) list.push_back(child);
    }
    const Json document = document_of(children);
    SCOPED_TRACE(document.dump());
    const absl::StatusOr<ImportedScene> scene = import_gltf(document);
    const bool is_sound = is_forest(children);
    ++(is_sound ? forests : others);
    // A forest of empty nodes is refused for its emptiness, if at all.
    const bool names_a_node =
        !scene.ok() && (scene.status().message().find("parent") != std::string::npos ||
                        scene.status().message().find("own descendants") != std::string::npos ||
                        scene.status().message().find("own child") != std::string::npos);
    EXPECT_EQ(names_a_node, !is_sound) << scene.status();
  }
  EXPECT_GT(forests, 100);
  EXPECT_GT(others, 100);
}

// ---------------------------------------------------------------- Mitsuba

class MitsubaGraphs : public MitsubaTest {
 protected:
  std::string error(const std::string& body) const { return error_of(import_xml(with_sensor(body))); }
};

TEST_F(MitsubaGraphs, FilesThatIncludeThemselvesAreRefusedByName) {
  write("loop.xml", "<scene version='3.0.0'><include filename='loop.xml'/></scene>");
  EXPECT_THAT(error("<include filename='loop.xml'/>"),
              AllOf(HasSubstr("loop.xml:1:"), HasSubstr("includes itself")));
  write("a.xml", "<scene version='3.0.0'><include filename='b.xml'/></scene>");
  write("b.xml", "<scene version='3.0.0'><include filename='a.xml'/></scene>");
  EXPECT_THAT(error("<include filename='a.xml'/>"),
              AllOf(HasSubstr("b.xml:1:"), HasSubstr("includes itself")));
}

TEST_F(MitsubaGraphs, FilesThatIncludeTheNextTenTimesAreBounded) {
  std::string ten;
  for (int i = 0; i < 14; ++i) {
    ten = "<scene version='3.0.0'>";
    for (int k = 0; k < 10; ++k) ten += "<include filename='level" + number(i + 1) + ".xml'/>";
    write("level" + number(i) + ".xml", ten + "</scene>");
  }
  write("level14.xml", "<scene version='3.0.0'/>");
  EXPECT_THAT(error("<include filename='level0.xml'/>"), HasSubstr("more than 100000 files are included"));
}

TEST_F(MitsubaGraphs, ParametersMadeOfParametersAreBounded) {
  std::string doubling = "<default name='p0' value='0123456789'/>";
  for (int i = 1; i <= 40; ++i)
    doubling += "<default name='p" + number(i) + "_' value='$p" + number(i - 1) + (i > 1 ? "_" : "") + "$p" +
                number(i - 1) + (i > 1 ? "_" : "") + "'/>\n";
  EXPECT_THAT(error(doubling), HasSubstr("the values of parameters come to more than 67108864 characters"));
}

TEST_F(MitsubaGraphs, MasksThatShareWhatTheyMaskAreBounded) {
  // Each level has two masks of the one below: 2^40 opacities.
  std::string levels = "<bsdf type='diffuse' id='b0'/>";
  for (int i = 1; i <= 40; ++i) {
    const std::string below = "<ref id='b" + number(i - 1) + "'/>";
    levels += "<bsdf type='blendbsdf' id='b" + number(i) + "'><float name='weight' value='0.5'/>" +
              "<bsdf type='mask'><float name='opacity' value='0.5'/>" + below + "</bsdf>" +
              "<bsdf type='mask'><float name='opacity' value='0.25'/>" + below + "</bsdf></bsdf>\n";
  }
  EXPECT_THAT(error(levels + "<shape type='sphere'><ref id='b40'/></shape>"),
              AllOf(HasSubstr("scene.xml:"), HasSubstr("shared by so many masks, maps and blends")));
}

TEST_F(MitsubaGraphs, GroupsOfInstancesOfGroupsStayAsManyAsTheyAre) {
  std::string levels = "<shape type='shapegroup' id='g0'><shape type='sphere'/></shape>";
  for (int i = 1; i <= 40; ++i) {
    const std::string instance = "<shape type='instance'><ref id='g" + number(i - 1) + "'/></shape>";
    levels += "<shape type='shapegroup' id='g" + number(i) + "'>" + instance + instance + "</shape>\n";
  }
  const ImportedScene imported = scene(levels + "<shape type='instance'><ref id='g40'/></shape>");
  EXPECT_EQ(imported.scene.objects_size(), 41);
}

TEST_F(MitsubaGraphs, TexturesOfTexturesAreWrittenOnce) {
  std::string levels = "<texture type='checkerboard' id='t0'/>";
  for (int i = 1; i <= 40; ++i) {
    const std::string below = number(i - 1);
    levels += "<texture type='checkerboard' id='t" + number(i) + "'><ref name='color0' id='t" + below +
              "'/><ref name='color1' id='t" + below + "'/></texture>\n";
  }
  const ImportedScene imported =
      scene(levels + "<shape type='sphere'><bsdf type='diffuse'><ref name='reflectance' id='t40'/></bsdf>" +
            "</shape>");
  EXPECT_EQ(imported.scene.textures_size(), 41);
}

// ---------------------------------------------------------------- pbrt

class PbrtGraphs : public ImportTest {
 protected:
  std::string error(const std::string& text) const { return error_of(import_world(text)); }
};

TEST_F(PbrtGraphs, FilesThatIncludeTheNextTwiceAreBounded) {
  for (int i = 0; i < 40; ++i) {
    const std::string next = "Include \"level" + number(i + 1) + ".pbrt\"\n";
    write("level" + number(i) + ".pbrt", next + next);
  }
  write("level40.pbrt", "");
  EXPECT_THAT(error("Include \"level0.pbrt\""), HasSubstr("more than 100000 files are included"));
}

TEST_F(PbrtGraphs, LargeFilesThatAreIncludedAgainAndAgainAreBounded) {
  write("large.pbrt", std::string(std::size_t{16} << 20, '\n'));
  std::string many;
  for (int i = 0; i < 66; ++i) many += "Include \"large.pbrt\"\n";
  EXPECT_THAT(error(many), HasSubstr("scene.pbrt:67:1: files that are included again and again come to"));
}

TEST_F(PbrtGraphs, LongChainsOfTexturesAreRefused) {
  std::string chain = "Texture \"t0\" \"float\" \"constant\" \"float value\" 0.5\n";
  for (int i = 1; i <= 100'000; ++i)
    chain +=
        "Texture \"t" + number(i) + "\" \"float\" \"scale\" \"texture tex\" \"t" + number(i - 1) + "\"\n";
  EXPECT_THAT(error(chain + "Shape \"sphere\" \"texture alpha\" \"t100000\""),
              HasSubstr("more than 64 textures within one another"));
}

TEST_F(PbrtGraphs, LongChainsOfMixesAreRefused) {
  std::string chain = "MakeNamedMaterial \"m0\" \"string type\" \"diffuse\"\n";
  for (int i = 1; i <= 100'000; ++i)
    chain += "MakeNamedMaterial \"m" + number(i) + "\" \"string type\" \"mix\" \"string materials\" [ \"m" +
             number(i - 1) + "\" \"m0\" ]\n";
  EXPECT_THAT(error(chain + "NamedMaterial \"m100000\" Shape \"sphere\""),
              HasSubstr("more than 64 mixes within one another"));
}

TEST_F(PbrtGraphs, SharedElementsAreWrittenOnce) {
  std::string levels =
      "Texture \"t0\" \"float\" \"constant\" \"float value\" 0.5\n"
      "MakeNamedMaterial \"m0\" \"string type\" \"diffuse\"\nObjectBegin \"o0\" Shape \"sphere\" ObjectEnd\n";
  for (int i = 1; i <= 40; ++i) {
    const std::string below = number(i - 1);
    levels += "Texture \"t" + number(i) + "\" \"float\" \"scale\" \"texture tex\" \"t" + below +
              "\" \"texture scale\" \"t" + below + "\"\nMakeNamedMaterial \"m" + number(i) +
              "\" \"string type\" \"mix\" \"string materials\" [ \"m" + below + "\" \"m" + below +
              "\" ]\nObjectBegin \"o" + number(i) + "\" ObjectInstance \"o" + below +
              "\" ObjectInstance \"o" + below + "\" ObjectEnd\n";
  }
  const ImportedScene imported = world(
      levels + "ObjectInstance \"o40\" NamedMaterial \"m40\" Shape \"sphere\" \"texture alpha\" \"t40\"");
  EXPECT_EQ(imported.scene.textures_size(), 41);
  EXPECT_EQ(imported.scene.materials_size(), 41);
  EXPECT_EQ(imported.scene.objects_size(), 41);
}

// ---------------------------------------------------------------- Tessera's own

class TextGraphs : public ImportTest {};

TEST_F(TextGraphs, CombinationsWithinOneAnotherAreRefused) {
  std::string deep = "shapes { ";
  for (int i = 0; i < 100'000; ++i) deep += "csg { parts { solid { ";
  EXPECT_THAT(error_of(import_scene(write("s.textproto", deep), {})),
              AllOf(HasSubstr("s.textproto:1:"), HasSubstr("too deep")));
}

// ---------------------------------------------------------------- formats that Assimp reads

class AssimpGraphs : public ImportTest {
 protected:
  /// A COLLADA file with these nodes in its library, the first of which its scene shows.
  static std::string collada(const std::string& nodes) {
    return R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="meter" meter="1"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="9">0 0 0 1 0 0 0 0 2</float_array>
<technique_common><accessor source="#a" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries><library_nodes>)" +
           nodes + R"(</library_nodes>
<library_visual_scenes><visual_scene id="s"><node id="root"><instance_node url="#n0"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
  }
};

TEST_F(AssimpGraphs, NodesThatHoldThemselvesAreRefused) {
  EXPECT_THAT(error_of(import_scene(
                  write("loop.dae", collada("<node id='n0'><instance_node url='#n0'/></node>")), {})),
              HasSubstr("loop.dae"));
  EXPECT_THAT(
      error_of(import_scene(write("two.dae", collada("<node id='n0'><instance_node url='#n1'/></node>"
                                                     "<node id='n1'><instance_node url='#n0'/></node>")),
                            {})),
      HasSubstr("two.dae"));
}

TEST_F(AssimpGraphs, NodesThatShareNodesAreBounded) {
  std::string levels;
  for (int i = 0; i < 40; ++i) {
    const std::string next = "<instance_node url='#n" + number(i + 1) + "'/>";
    levels += "<node id='n" + number(i) + "'>" + next + next + "</node>";
  }
  levels += "<node id='n40'><instance_geometry url='#g'/></node>";
  EXPECT_THAT(error_of(import_scene(write("diamonds.dae", collada(levels)), {})), HasSubstr("diamonds.dae"));
}

}  // namespace
}  // namespace tessera::client
