#include "render/scene/shape/shading_groups.h"

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <vector>

namespace tessera::render {

void group_for_shading(const ShapeTable& shapes, const MaterialTable& materials, SceneTables& tables) {
  // Materials in an order in which neighbours cost least together: of one kind, of one texture.
  const auto key_of = [&](const ShapeRecord& shape) {
    const MaterialRecord& material = materials.materials[static_cast<std::size_t>(shape.material)];
    return std::tuple(material.kind, material.flags, material.variants, material.spectra[0].texture,
                      shape.material, shape.first_light >= 0);
  };
  using Key = decltype(key_of(shapes.shapes[0]));
  std::vector<Key> keys;
  for (const ShapeRecord& shape : shapes.shapes) keys.push_back(key_of(shape));
  std::ranges::sort(keys);
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());

  // Where all are of one kind, and no texture is looked up, there is nothing to gain.
  const bool alike = std::ranges::all_of(keys, [&](const Key& key) {
    return std::get<0>(key) == std::get<0>(keys[0]) && (std::get<1>(key) & kHasTextures) == 0;
  });
  if (alike) return;
  const std::size_t keys_a_group = (keys.size() + kMostShadingGroups - 1) / kMostShadingGroups;
  tables.shading_groups = static_cast<std::int32_t>((keys.size() + keys_a_group - 1) / keys_a_group);
  for (const ShapeRecord& shape : shapes.shapes) {
    const auto place = std::ranges::lower_bound(keys, key_of(shape)) - keys.begin();
    tables.shading_group.push_back(static_cast<std::uint8_t>(static_cast<std::size_t>(place) / keys_a_group));
  }
}

}  // namespace tessera::render
