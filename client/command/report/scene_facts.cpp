#include "command/report/scene_facts.h"

#include <functional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "command/report/camera_facts.h"
#include "command/report/item_names.h"
#include "image/cryptomatte.h"
#include "wire/aov_channels.h"

namespace tessera::client {
namespace {

constexpr const char kObjects[] = "CryptoObject", kMaterials[] = "CryptoMaterial", kAssets[] = "CryptoAsset";

/// Shapes in the order of their numbers: those of the world, then those of the objects.
std::vector<const v1::Shape*> shapes_of(const v1::Scene& scene) {
  std::vector<const v1::Shape*> shapes;
  for (const v1::Shape& shape : scene.shapes()) shapes.push_back(&shape);
  for (const v1::Object& object : scene.objects()) {
    for (const v1::Shape& shape : object.shapes()) shapes.push_back(&shape);
  }
  return shapes;
}

std::string name_or(const std::string& name, const char* kind, std::int64_t number) {
  return name.empty() ? absl::StrCat(kind, " ", number) : name;
}

void add_mattes(const v1::Scene& scene, std::uint32_t ranks, Image& image) {
  const std::vector<const v1::Shape*> shapes = shapes_of(scene);
  const auto shape_name = [&](std::int64_t number) {
    const auto i = static_cast<std::size_t>(number - 1);
    return name_or(i < shapes.size() ? shapes[i]->name() : "", "object", number);
  };
  const auto material_name = [&](std::int64_t number) {
    const int i = static_cast<int>(number - 1);
    if (i == scene.materials_size()) return std::string("(default)");
    return name_or(i >= 0 && i < scene.materials_size() ? scene.materials(i).name() : "", "material", number);
  };
  // Instances have positive numbers, and shapes that nothing places have their own, with a minus.
  const auto asset_name = [&](std::int64_t number) {
    if (number > 0)
      return name_or(
          number <= scene.instances_size() ? scene.instances(static_cast<int>(number - 1)).object() : "",
          "instance", number);
    const auto i = static_cast<std::size_t>(-number - 1);
    const bool grouped = i < shapes.size() && !shapes[i]->group().empty();
    return grouped ? shapes[i]->group() : shape_name(-number);
  };
  resolve_mattes(wire::kObjectList, kObjects, ranks, shape_name, image);
  resolve_mattes(wire::kMaterialList, kMaterials, ranks, material_name, image);
  resolve_mattes(wire::kAssetList, kAssets, ranks, asset_name, image);
}

}  // namespace

void add_scene_facts(const v1::Scene& scene, const v1::JobSpec& spec, std::uint32_t matte_ranks,
                     Image& image) {
  add_item_names(scene, spec, image);
  add_camera_facts(scene.camera(), image);
  add_mattes(scene, matte_ranks, image);
}

void resolve_nameless_mattes(std::uint32_t matte_ranks, Image& image) {
  const auto numbered = [](const char* kind) {
    return [kind](std::int64_t number) { return absl::StrCat(kind, " ", number); };
  };
  resolve_mattes(wire::kObjectList, kObjects, matte_ranks, numbered("object"), image);
  resolve_mattes(wire::kMaterialList, kMaterials, matte_ranks, numbered("material"), image);
  resolve_mattes(wire::kAssetList, kAssets, matte_ranks, numbered("asset"), image);
}

}  // namespace tessera::client
