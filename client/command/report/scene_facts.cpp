#include "command/report/scene_facts.h"

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "command/report/camera_facts.h"
#include "command/report/item_names.h"
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

/// The object that instance `number` places, from 1 on; empty where there is no such instance.
std::string object_of_instance(const v1::Scene& scene, std::int64_t number) {
  if (number <= scene.instances_size()) return scene.instances(static_cast<int>(number - 1)).object();
  auto left = static_cast<std::uint64_t>(number - scene.instances_size());
  for (const v1::PackedInstances::Run& run : scene.packed_instances().runs()) {
    if (left <= run.count()) return run.object();
    left -= run.count();
  }
  return "";
}

std::string name_or(const std::string& name, const char* kind, std::int64_t number) {
  return name.empty() ? absl::StrCat(kind, " ", number) : name;
}

}  // namespace

std::vector<MatteList> mattes_of(const v1::Scene& scene, std::uint32_t ranks) {
  const std::vector<const v1::Shape*> shapes = shapes_of(scene);
  const auto shape_name = [shapes](std::int64_t number) {
    const auto i = static_cast<std::size_t>(number - 1);
    return name_or(i < shapes.size() ? shapes[i]->name() : "", "object", number);
  };
  const auto material_name = [&scene](std::int64_t number) {
    if (number == scene.materials_size() + 1) return std::string("(default)");
    const bool is_known = number > 0 && number <= scene.materials_size();
    return name_or(is_known ? scene.materials(static_cast<int>(number - 1)).name() : "", "material", number);
  };
  // Instances have positive numbers, and shapes that nothing places have their own, with a minus.
  const auto asset_name = [&scene, shapes, shape_name](std::int64_t number) {
    if (number > 0) return name_or(object_of_instance(scene, number), "instance", number);
    const auto i = static_cast<std::size_t>(-number - 1);
    const bool grouped = i < shapes.size() && !shapes[i]->group().empty();
    return grouped ? shapes[i]->group() : shape_name(-number);
  };
  return {{wire::kObjectList, kObjects, ranks, shape_name},
          {wire::kMaterialList, kMaterials, ranks, material_name},
          {wire::kAssetList, kAssets, ranks, asset_name}};
}

std::vector<MatteList> nameless_mattes(std::uint32_t ranks) {
  const auto numbered = [](const char* kind) {
    return [kind](std::int64_t number) { return absl::StrCat(kind, " ", number); };
  };
  return {{wire::kObjectList, kObjects, ranks, numbered("object")},
          {wire::kMaterialList, kMaterials, ranks, numbered("material")},
          {wire::kAssetList, kAssets, ranks, numbered("asset")}};
}

void add_scene_facts(const v1::Scene& scene, const v1::Camera& camera, const v1::JobSpec& spec,
                     Image& image) {
  add_item_names(scene, spec, image);
  add_camera_facts(camera, image);
  add_exposure_facts(scene.film(), spec.view().exposure(), camera, image);
  add_luminance_facts(scene, spec.view().exposure(), camera, image);
}

}  // namespace tessera::client
