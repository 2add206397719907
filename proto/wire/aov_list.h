// The list of AOVs of what a camera ray meets first, for the contract's code, which makes channels of them,
// and for kernels, which know no messages. A new one is a value of v1::AOV, a row here, and a line of
// render/transport/vertex/first_hits.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "wire/tile_result.h"

namespace tessera::wire {

/// The AOVs, in the order of their numbers in v1::AOV, and so of their channels in results.
enum class HitAov : std::uint8_t {
  kAlbedo,
  kNormal,
  kDepth,
  kId,
  kVisits,
  kPosition,
  kCameraNormal,
  kUv,
  kMotion,
  kMaterialId,
  kCryptoObject,
  kCryptoMaterial,
  kCryptoAsset
};

struct HitAovRow {
  HitAov aov;
  const char* word;  // the word of v1::AOV
  /// Names of channels; of a list of identifiers (kEntry) the name that its channels begin with.
  const char* channels[3];
  ChannelKind kind = ChannelKind::kSum;
  bool of_shape = false;  // it depends on which shape was met, not on the point alone

  constexpr int channel_count() const { return channels[2] != nullptr ? 3 : channels[1] != nullptr ? 2 : 1; }
};

inline constexpr const char kObjectList[] = "crypto-object", kMaterialList[] = "crypto-material",
                            kAssetList[] = "crypto-asset";

inline constexpr HitAovRow kHitAovs[] = {
    {HitAov::kAlbedo, "albedo", {"albedo.R", "albedo.G", "albedo.B"}},
    {HitAov::kNormal, "normal", {"normal.X", "normal.Y", "normal.Z"}},
    {HitAov::kDepth, "depth", {"depth.Z"}},
    {HitAov::kId, "id", {"id.shape", "id.instance"}, ChannelKind::kFirst, true},
    {HitAov::kVisits, "visits", {"visits.nodes", "visits.primitives"}},
    {HitAov::kPosition, "position", {"position.X", "position.Y", "position.Z"}},
    {HitAov::kCameraNormal, "camera-normal", {"camera-normal.X", "camera-normal.Y", "camera-normal.Z"}},
    {HitAov::kUv, "uv", {"uv.U", "uv.V"}},
    {HitAov::kMotion, "motion", {"motion.U", "motion.V"}, ChannelKind::kSum, true},
    {HitAov::kMaterialId, "material-id", {"id.material"}, ChannelKind::kFirst, true},
    {HitAov::kCryptoObject, kObjectList, {kObjectList}, ChannelKind::kEntry, true},
    {HitAov::kCryptoMaterial, kMaterialList, {kMaterialList}, ChannelKind::kEntry, true},
    {HitAov::kCryptoAsset, kAssetList, {kAssetList}, ChannelKind::kEntry, true},
};

/// The AOV of this word; null where it is another one, or none.
constexpr const HitAovRow* find_hit_aov(std::string_view word) {
  for (const HitAovRow& row : kHitAovs) {
    if (row.word == word) return &row;
  }
  return nullptr;
}

}  // namespace tessera::wire
